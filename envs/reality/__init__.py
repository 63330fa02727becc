"""What stands between a robot's policy and its world: an estimate, delays, and what varies.

`REAL` is how `cube-centre` has it; `Reality()` is all zero, where nothing stands between.
"""

from dataclasses import dataclass, field, replace

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct

from pigbench.envs.control import ACTION_SIZE
from pigbench.envs.physics import PhysicsState
from pigbench.envs.reality import delay, estimate, variation
from pigbench.envs.reality.estimate import PoseEstimate
from pigbench.envs.reality.variation import Variation
from pigbench.envs.scene import Scene


@dataclass(frozen=True)
class Reality:
    """The parts, each of which may be set to zero.

    Attributes:
        estimate: how the cubes' poses are known.
        action_delay: control steps until an action is carried out.
        variation: what an episode's dynamics are drawn from.
    """

    estimate: PoseEstimate = field(default_factory=PoseEstimate)
    action_delay: int = 0
    variation: Variation = field(default_factory=Variation)


REAL = Reality(
    estimate=PoseEstimate(
        # FoundationPose (Wen et al., CVPR 2024, table 1): areas under the curve up to 10 cm of
        # 97.4 % (ADD-S) and 91.5 % (ADD) on YCB-Video are mean errors of 2.6 and 8.5 mm, the second
        # with turns that symmetric objects do not show. The depth of a D415 (baseline 55 mm, 65
        # degrees over 1280 pixels) is off by 1.4 mm at a metre if disparity is by 0.08 pixels
        # (Intel's notes on tuning its D400 cameras expect less than 0.1); a pose averages over it.
        position_noise=0.002,
        yaw_noise=np.radians(2.0),
        # Calibrations of a camera beside an arm are commonly good to a few millimetres.
        position_bias=0.003,
        yaw_bias=np.radians(1.0),
        # Its tail (ADD recalls of whole benchmarks are means over frames that are good or far off)
        # is this model's assumption, not a published figure.
        misregistration=0.1,
        misregistration_bias=0.03,
        dropout=0.02,
        # Half the fingers' length: they hide what is between them, not the whole of a cube.
        occlusion_distance=0.05,
        occluded_dropout=0.3,
        # 30 frames per second, and FoundationPose's tracking at 32: two control steps, rounded up.
        latency=2,
    ),
    action_delay=1,  # a servo command's way through the controller, rounded up to a control step
    variation=Variation(friction=0.3, mass=0.3),
)


@struct.dataclass
class Senses:
    """An episode's: key and number of its next draws, what is known, what is under way."""

    key: jax.Array  # as bare numbers: Brax's wrappers and others take states for arrays of such
    time: jax.Array  # ()
    track: estimate.Track
    actions: jax.Array  # (action_delay, 5)


@struct.dataclass
class World:
    """A simulation, and what stands between it and whoever acts in it: None is nothing."""

    physics: PhysicsState
    senses: Senses | None


def begin(key: jax.Array, reality: Reality, scene: Scene, physics: PhysicsState) -> World:
    """An episode's world, from a simulation at rest."""
    factors_key, track_key, key = jax.random.split(key, 3)
    physics = replace(physics, factors=variation.draw(factors_key, reality.variation))
    senses = Senses(
        key=jax.random.key_data(key),
        time=jnp.zeros((), jnp.int32),
        track=estimate.begin(track_key, reality.estimate, scene, physics),
        actions=delay.begin(jnp.zeros(ACTION_SIZE), reality.action_delay),
    )
    return World(physics, senses)


def act(senses: Senses, action: jax.Array) -> tuple[Senses, jax.Array]:
    """The action (5,) that is carried out now, given that which is asked for now."""
    actions, due = delay.push(senses.actions, action)
    return replace(senses, actions=actions), due


def look(reality: Reality, scene: Scene, senses: Senses, physics: PhysicsState) -> Senses:
    """What is known after a control step."""
    key = jax.random.fold_in(jax.random.wrap_key_data(senses.key), senses.time)
    track = estimate.advance(key, reality.estimate, scene, senses.track, physics)
    return replace(senses, time=senses.time + 1, track=track)


def perceived(scene: Scene, world: World) -> PhysicsState:
    """The simulation as it seems to whoever acts in it: cubes are where they are thought to be."""
    if world.senses is None:
        return world.physics
    qpos = world.physics.qpos.at[scene.cubes_qpos].set(world.senses.track.known.ravel())
    return replace(world.physics, qpos=qpos)
