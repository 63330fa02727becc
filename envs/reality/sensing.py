"""A simulation and the imperfections through which a policy senses it and acts in it."""

from dataclasses import replace

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float, Int, PRNGKeyArray, UInt32

from pigbench import seeds
from pigbench.envs.physics import PhysicsState
from pigbench.envs.reality import Reality, delay, estimate, variation
from pigbench.envs.scene import Scene
from pigbench.envs.units import ACTION_SIZE


@struct.dataclass
class Senses:
    """The state of an episode's imperfections."""

    key: UInt32[Array, "2"]  # Threefry's words, because Brax's wrappers and others expect arrays
    time: Int[Array, ""]  # control steps, folded into the key for the next draws
    track: estimate.Track
    actions: Float[Array, "delay action"]  # requested and not yet executed


@struct.dataclass
class World:
    """A simulation, and the imperfections through which a policy sees it; None without any."""

    physics: PhysicsState
    senses: Senses | None


def begin(key: PRNGKeyArray, reality: Reality, scene: Scene, physics: PhysicsState) -> World:
    """The world at the start of an episode, from a simulation at rest."""
    factors_key, track_key, key = jax.random.split(key, 3)
    physics = replace(physics, factors=variation.draw(factors_key, reality.variation))
    senses = Senses(
        key=jax.random.key_data(key)[:2],  # a user's own may be of another implementation
        time=jnp.zeros((), jnp.int32),
        track=estimate.begin(track_key, reality.estimate, scene, physics),
        actions=delay.begin(jnp.zeros(ACTION_SIZE), reality.action_delay),
    )
    return World(physics, senses)


def act(senses: Senses, action: Float[Array, "action"]) -> tuple[Senses, Float[Array, "action"]]:
    """The senses after `action` is requested, and the action that is executed now."""
    actions, due = delay.push(senses.actions, action)
    return replace(senses, actions=actions), due


def look(reality: Reality, scene: Scene, senses: Senses, physics: PhysicsState) -> Senses:
    """The senses after a control step that led to `physics`."""
    key = jax.random.wrap_key_data(senses.key, impl=seeds.IMPLEMENTATION)
    key = jax.random.fold_in(key, senses.time)
    track = estimate.advance(key, reality.estimate, scene, senses.track, physics)
    return replace(senses, time=senses.time + 1, track=track)


def perceived(scene: Scene, world: World) -> PhysicsState:
    """The simulation as the policy perceives it, with the cubes at their estimated poses."""
    if world.senses is None:
        return world.physics
    qpos = world.physics.qpos.at[scene.cubes_qpos].set(world.senses.track.known.ravel())
    return replace(world.physics, qpos=qpos)
