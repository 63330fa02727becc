"""The `replan` policy: a robot's controller, which knows only an estimate of the cube's pose.

It brings the only cube home, which is the tasks' goal if they share one and the table's centre if
not, then away to a random place, and then the episode ends. At every control step, it recomputes
the remaining places of the plan from the effector's pose and the estimated pose of the cube, and
takes the first step towards the next place. It thus corrects a wrong estimate while there is time,
and fetches a cube that slips; if the estimate stays wrong, it fails.

A sampling-based controller would do the same by simulating every candidate. On two cores, a data
set of 80,000 steps would take hours instead of minutes, and its model would be identical to the
simulation that it acts in, which no robot has.
"""

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from pigbench.envs import control, workspace
from pigbench.envs.cubes import CUBE_HALF_SIZE
from pigbench.envs.observation import cube_poses, gripper_contact
from pigbench.envs.oracles.policy import ScriptedPolicy
from pigbench.envs.oracles.targets import Target
from pigbench.envs.physics import PhysicsState
from pigbench.envs.rotations import nearest_symmetry, quat_yaw
from pigbench.envs.scene import Scene
from pigbench.envs.scripted import SCRIPTED, TRIP_STEPS, TRIPS
from pigbench.envs.spec import EnvSpec
from pigbench.envs.units import ACTION_SCALE, ACTION_SIZE

HORIZON = 3  # control steps in which to reach the next place, if speed allows
SPEED = (0.4, 0.8)  # range of an episode's speed, as a share of the largest action
LIFT = (0.08, 0.20)  # range of an episode's height of approach and carrying, metres
ALIGNED = 0.15  # radians of yaw within which a place is reached
PLACED = 0.025  # metres in x and y within which a cube is at its target
LET_GO = 0.1  # contact below which nothing is held


@dataclass(frozen=True)
class Stage:
    """A place on the way.

    Attributes:
        opening: the gripper's opening, 0 open and 1 shut.
        within: metres along each axis within which the place is reached.
        wait: control steps to stay there.
        holding: whether the cube counts as lost if the gripper feels no contact.
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
    """The policy's memory between control steps of one episode."""

    lift: Float[Array, ""]  # metres, fixed for the episode
    speed: Float[Array, ""]  # share of the largest action, fixed for the episode
    away: Float[Array, "2"]  # metres, where the cube is brought after it was at home
    yaws: Float[Array, "trip"]  # radians, of the cube's targets
    trip: Int[Array, ""]  # index of the current trip
    stage: Int[Array, ""]  # index in STAGES
    waited: Int[Array, ""]  # control steps waited there
    time: Int[Array, ""]  # control steps since the trip began
    action: Float[Array, "action"]  # the next action


def home(spec: EnvSpec) -> tuple[float, ...]:
    """(x, y) in metres of the tasks' goal if they share one, else of the table's centre."""
    first, *others = {place[:2] for task in spec.tasks for place in task.goal}
    return workspace.CUBE.middle if others else first


class ReplanPolicy(ScriptedPolicy[ReplanState]):
    """Moves the cube home and then away."""

    ability = SCRIPTED["replan"]

    def __init__(self, spec: EnvSpec, scene: Scene):
        super().__init__(spec, scene)
        self._home = home(spec)

    def reset(self, key: PRNGKeyArray, physics_state: PhysicsState) -> ReplanState:
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
            action=jnp.zeros(ACTION_SIZE),
        )
        return replace(state, action=self._plan(state, physics_state))

    def act(
        self, key: PRNGKeyArray, state: ReplanState, physics_state: PhysicsState
    ) -> Float[Array, "action"]:
        """The action that was planned from the state. `key` is unused."""
        return state.action

    def advance(
        self, key: PRNGKeyArray, state: ReplanState, physics_state: PhysicsState
    ) -> ReplanState:
        """Update the progress of the trip, and replan."""
        state = self._next_trip(self._next_stage(state, physics_state), physics_state)
        return replace(state, action=self._plan(state, physics_state))

    def ended(self, state: ReplanState) -> Bool[Array, ""]:
        """Whether the trip is given up after the current action.

        The end of a trip that succeeds is known only after the action.
        """
        return state.time >= TRIP_STEPS - 1

    def finished(self, state: ReplanState) -> Bool[Array, ""]:
        """Whether both trips are over."""
        return state.trip >= TRIPS

    def target(self, state: ReplanState) -> Target:
        """The target of the current trip."""
        away = jnp.where(state.trip == 0, jnp.array(self._home), state.away)
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
        """End the trip if the cube is placed once the plan is through; if not, restart the plan."""
        cube = cube_poses(self.scene, seen)[0][0]
        through = state.stage >= len(STAGES)
        placed = jnp.linalg.norm((cube - self.target(state).pos)[:2]) < PLACED
        over = (through & placed) | (state.time >= TRIP_STEPS)
        return replace(
            state,
            trip=state.trip + over,
            stage=jnp.where(over | through, 0, state.stage),
            waited=jnp.where(over, 0, state.waited),
            time=jnp.where(over, 0, state.time),
        )

    def _places(self, state: ReplanState, seen: PhysicsState) -> Float[Array, "stage 4"]:
        """The effector's position and yaw at each stage, for the estimated cube."""
        positions, quats = cube_poses(self.scene, seen)
        target, hand = self.target(state), control.effector(self.scene, seen)[:4]
        pick = jnp.append(
            workspace.PINCH.clip(positions[0]), nearest_symmetry(quat_yaw(quats[0]), hand[3])
        )
        place = jnp.append(target.pos, nearest_symmetry(target.yaw, hand[3]))

        def above(place: Float[Array, "4"]) -> Float[Array, "4"]:
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

    def _plan(self, state: ReplanState, seen: PhysicsState) -> Float[Array, "action"]:
        """The first action towards the next place."""
        stage = jnp.minimum(state.stage, len(STAGES) - 1)
        way = self._places(state, seen)[stage] - control.effector(self.scene, seen)[:4]
        move = way / HORIZON / jnp.array(ACTION_SCALE[:4])
        move *= state.speed / jnp.maximum(jnp.max(jnp.abs(move)), state.speed)
        return jnp.append(move, 2 * jnp.array(_TABLE["opening"])[stage] - 1)
