"""The `replan` policy: what a robot's controller does, which knows of the cube what it estimates.

It brings the cube to the table's centre, then away to a random place, and the episode ends. At
every control step the places that are left of the plan are laid anew, from the effector as it is
and the cube as it seems, and of the way to the next of them the first step is taken. So a wrong
estimate is made good while there is time, a cube that slips is fetched again, and what stays wrong
fails.

A sampling-based controller would do the same with a simulation of every candidate: on two cores a
data set of 80,000 steps takes it hours instead of minutes, and its model would be the very one that
it acts in, which no robot has.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct

from pigbench.envs import control, workspace
from pigbench.envs.observation import cube_poses, gripper_contact
from pigbench.envs.oracles.policy import Policy
from pigbench.envs.oracles.targets import Target
from pigbench.envs.physics import PhysicsState
from pigbench.envs.rotations import nearest_symmetry, quat_yaw
from pigbench.envs.scene import CUBE_HALF_SIZE
from pigbench.envs.units import CENTRE

TRIPS = 2  # to the centre, and away
MAX_STEPS = 150  # control steps after which a trip is given up
HORIZON = 3  # control steps in which the next place is reached, if speed allows
SPEED = (0.4, 0.8)  # an episode's, of the largest action
LIFT = (0.08, 0.20)  # metres above the table at which cubes are approached and carried, likewise
ALIGNED = 0.15  # radians of yaw within which a place is reached
PLACED = 0.025  # metres in x and y within which a cube is where it was to be
LET_GO = 0.1  # contact below which nothing is held


@dataclass(frozen=True)
class Stage:
    """A place on the way.

    Attributes:
        opening: the gripper's, 0 open and 1 shut.
        within: metres along each axis within which the place is reached.
        wait: control steps to stay once there.
        holding: whether the cube is lost if the gripper feels nothing.
    """

    opening: float
    within: float
    wait: int = 0
    holding: bool = False


STAGES = {
    "above_pick": Stage(0.0, 0.02),
    "pick": Stage(0.0, 0.01),
    "grasp": Stage(1.0, 0.02, wait=8),
    "lift": Stage(1.0, 0.03, holding=True),
    "above_place": Stage(1.0, 0.02, holding=True),
    "place": Stage(1.0, 0.01, holding=True),
    "release": Stage(0.0, 0.02, wait=5),
    "retreat": Stage(0.0, 0.03),
}
_TABLE = {
    name: np.array([getattr(stage, name) for stage in STAGES.values()])
    for name in ("opening", "within", "wait", "holding")
}


@struct.dataclass
class ReplanState:
    """What the policy remembers between control steps of one episode."""

    lift: jax.Array  # () metres, fixed for the episode
    speed: jax.Array  # () of the largest action, likewise
    away: jax.Array  # (2,) metres, where the cube is brought after the centre
    yaws: jax.Array  # (TRIPS,) radians, how it is put down
    trip: jax.Array  # () number of the present one
    stage: jax.Array  # () number in STAGES
    waited: jax.Array  # () control steps there
    time: jax.Array  # () control steps since the trip began
    action: jax.Array  # (5,) the next


class ReplanPolicy(Policy[ReplanState]):
    """To the centre and away."""

    episode_rows: ClassVar[int] = TRIPS * MAX_STEPS + 1

    def reset(self, key: jax.Array, physics_state: PhysicsState) -> ReplanState:
        """Begin an episode."""
        lift_key, speed_key, away_key, yaw_key = jax.random.split(key, 4)
        zero = jnp.zeros((), jnp.int32)
        state = ReplanState(
            lift=jax.random.uniform(lift_key, minval=LIFT[0], maxval=LIFT[1]),
            speed=jax.random.uniform(speed_key, minval=SPEED[0], maxval=SPEED[1]),
            away=workspace.CUBE.sample(away_key),
            yaws=jax.random.uniform(yaw_key, (TRIPS,), maxval=2 * jnp.pi),
            trip=zero,
            stage=zero,
            waited=zero,
            time=zero,
            action=jnp.zeros(control.ACTION_SIZE),
        )
        return replace(state, action=self._plan(state, physics_state))

    def act(self, key: jax.Array, state: ReplanState, physics_state: PhysicsState) -> jax.Array:
        """The action (5,) that was planned from the state. Draws nothing from `key`."""
        return state.action

    def advance(
        self, key: jax.Array, state: ReplanState, physics_state: PhysicsState
    ) -> ReplanState:
        """Take note of how far the trip is, and plan anew."""
        state = self._next_trip(self._next_stage(state, physics_state), physics_state)
        return replace(state, action=self._plan(state, physics_state))

    def ended(self, state: ReplanState) -> jax.Array:
        """Whether a trip is given up after the present action; one that succeeds is found out."""
        return state.time >= MAX_STEPS - 1

    def finished(self, state: ReplanState) -> jax.Array:
        """Whether both trips are over, () bool."""
        return state.trip >= TRIPS

    def target(self, state: ReplanState) -> Target:
        """Where the present trip leads."""
        away = jnp.where(state.trip == 0, jnp.array(CENTRE[:2]), state.away)
        yaw = state.yaws[jnp.minimum(state.trip, TRIPS - 1)]
        return Target(jnp.zeros((), jnp.int32), jnp.append(away, CUBE_HALF_SIZE), yaw)

    def _next_stage(self, state: ReplanState, seen: PhysicsState) -> ReplanState:
        goal = self._places(state, seen)[state.stage]
        off = goal - control.effector(self.scene, seen)[:4]
        near = jnp.max(jnp.abs(off[:3])) < jnp.array(_TABLE["within"])[state.stage]
        there = near & (jnp.abs(off[3]) < ALIGNED)
        waited = state.waited + there
        reached = there & (waited > jnp.array(_TABLE["wait"])[state.stage])
        lost = jnp.array(_TABLE["holding"])[state.stage] & (gripper_contact(seen) < LET_GO)
        stage = jnp.where(lost, 0, state.stage + reached)
        waited = jnp.where(lost | reached, 0, waited)
        return replace(state, stage=stage, waited=waited, time=state.time + 1)

    def _next_trip(self, state: ReplanState, seen: PhysicsState) -> ReplanState:
        """Where the plan is through, look: a cube that is elsewhere is fetched again."""
        cube = cube_poses(self.scene, seen)[0][0]
        through = state.stage >= len(STAGES)
        placed = jnp.linalg.norm((cube - self.target(state).pos)[:2]) < PLACED
        over = (through & placed) | (state.time >= MAX_STEPS)
        return replace(
            state,
            trip=state.trip + over,
            stage=jnp.where(over | through, 0, state.stage),
            waited=jnp.where(over, 0, state.waited),
            time=jnp.where(over, 0, state.time),
        )

    def _places(self, state: ReplanState, seen: PhysicsState) -> jax.Array:
        """The effector's position and yaw at each stage, (stages, 4), the cube as it seems."""
        positions, quats = cube_poses(self.scene, seen)
        target, hand = self.target(state), control.effector(self.scene, seen)[:4]
        pick = jnp.append(
            workspace.PINCH.clip(positions[0]), nearest_symmetry(quat_yaw(quats[0]), hand[3])
        )
        place = jnp.append(target.pos, nearest_symmetry(target.yaw, hand[3]))

        def above(place: jax.Array) -> jax.Array:
            return place.at[2].set(state.lift)

        places = {
            "above_pick": above(pick),
            "pick": pick,
            "grasp": hand,
            "lift": above(hand),
            "above_place": above(place),
            "place": place,
            "release": hand,
            "retreat": above(hand),
        }
        return jnp.stack([places[name] for name in STAGES])

    def _plan(self, state: ReplanState, seen: PhysicsState) -> jax.Array:
        """The first action (5,) of the way to the next place."""
        stage = jnp.minimum(state.stage, len(STAGES) - 1)
        way = self._places(state, seen)[stage] - control.effector(self.scene, seen)[:4]
        move = way / HORIZON / jnp.array(control.ACTION_SCALE[:4])
        move *= state.speed / jnp.maximum(jnp.max(jnp.abs(move)), state.speed)
        return jnp.append(move, 2 * jnp.array(_TABLE["opening"])[stage] - 1)
