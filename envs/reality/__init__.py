"""The imperfections of a real robot: estimated poses, delays and varying dynamics.

`REAL` is the setting of `cube-centre`; in `Reality()`, everything is zero, so nothing is imperfect.
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
    """The imperfections, each of which may be set to zero.

    Attributes:
        estimate: how the cubes' poses are estimated.
        action_delay: control steps until an action is executed.
        variation: the range of an episode's dynamics.
    """

    estimate: PoseEstimate = field(default_factory=PoseEstimate)
    action_delay: int = 0
    variation: Variation = field(default_factory=Variation)


REAL = Reality(
    estimate=PoseEstimate(
        # FoundationPose (Wen et al., CVPR 2024, table 1): areas under the curve up to 10 cm of
        # 97.4 % (ADD-S) and 91.5 % (ADD) on YCB-Video are mean errors of 2.6 and 8.5 mm, and the
        # latter counts rotations under which an object is symmetric. The depth of a D415 (baseline
        # 55 mm, 65 degrees over 1280 pixels) is off by 1.4 mm at a metre if the disparity is off by
        # 0.08 pixels (Intel's notes on tuning its D400 cameras expect less than 0.1); a pose
        # averages over it.
        position_noise=0.002,
        yaw_noise=np.radians(2.0),
        # The calibration of a camera beside an arm is commonly accurate to a few millimetres.
        position_bias=0.003,
        yaw_bias=np.radians(1.0),
        # The tail of the errors is an assumption of this model, not a published figure (published
        # ADD recalls are means over frames that are good or far off).
        misregistration=0.1,
        misregistration_bias=0.03,
        dropout=0.02,
        # Half the fingers' length: they hide what is between them, not a whole cube.
        occlusion_distance=0.05,
        occluded_dropout=0.3,
        # 30 frames per second, and FoundationPose tracks at 32: two control steps, rounded up.
        latency=2,
    ),
    action_delay=1,  # a servo command's time in the controller, rounded up to a control step
    variation=Variation(friction=0.3, mass=0.3),
)


@struct.dataclass
class Senses:
    """The state of an episode's imperfections."""

    key: jax.Array  # as raw numbers, because Brax's wrappers and others expect such arrays
    time: jax.Array  # () control steps, folded into the key for the next draws
    track: estimate.Track
    actions: jax.Array  # (action_delay, 5), requested and not yet executed


@struct.dataclass
class World:
    """A simulation, and the imperfections through which a policy sees it; None without any."""

    physics: PhysicsState
    senses: Senses | None


def begin(key: jax.Array, reality: Reality, scene: Scene, physics: PhysicsState) -> World:
    """The world at the start of an episode, from a simulation at rest."""
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
    """The senses after `action` (5,) is requested, and the action (5,) that is executed now."""
    actions, due = delay.push(senses.actions, action)
    return replace(senses, actions=actions), due


def look(reality: Reality, scene: Scene, senses: Senses, physics: PhysicsState) -> Senses:
    """The senses after a control step that led to `physics`."""
    key = jax.random.fold_in(jax.random.wrap_key_data(senses.key), senses.time)
    track = estimate.advance(key, reality.estimate, scene, senses.track, physics)
    return replace(senses, time=senses.time + 1, track=track)


def perceived(scene: Scene, world: World) -> PhysicsState:
    """The simulation as the policy perceives it, with the cubes at their estimated poses."""
    if world.senses is None:
        return world.physics
    qpos = world.physics.qpos.at[scene.cubes_qpos].set(world.senses.track.known.ravel())
    return replace(world.physics, qpos=qpos)
