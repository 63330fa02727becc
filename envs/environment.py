"""The cube environment, a Brax `Env` with Brax's `State`: move every cube to its target."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, ArrayLike, Bool, Float, Int, PRNGKeyArray

from pigbench.envs import control, kinematics, observation, terms, trees, workspace
from pigbench.envs.cubes import CUBE_HALF_SIZE
from pigbench.envs.observation import cube_poses
from pigbench.envs.physics import Physics, PhysicsState
from pigbench.envs.quiet import quiet
from pigbench.envs.reality import Reality, sensing
from pigbench.envs.reality.sensing import World
from pigbench.envs.rewards import REWARDS, Situation
from pigbench.envs.rotations import yaw_quat
from pigbench.envs.spec import EnvSpec
from pigbench.envs.tasks import START_JITTER
from pigbench.envs.units import ACTION_SIZE
from pigbench.errors import UserError, lookup
from pigbench.layout import Space
from pigbench.settings import jax_defaults

with quiet():
    from brax.envs.base import Env, State

SETTLING_STEPS = 2  # random control steps before a goal scene is observed
USER_TASK = 0  # task id of a scene that the user gave; ids of the table's tasks start at 1
_REALITY = 1000  # folded into an episode's key, for the draws of its `reality`
NO_TASK = -1  # replaces an invalid task id that is traced, so that it cannot be refused

TaskId = Int[Array, ""] | int | np.integer


class CubeEnv(Env):
    """A UR5e that rearranges cubes.

    `layout` describes the observation, and `envs.control` the action, in [-1, 1]. The reward
    is 1 on success, else 0, or another of `envs.rewards`. An episode is done when every cube is
    within the spec's `success_distance` of its target, or when the simulation has diverged; time
    limits are left to a wrapper (`episode_length` is OGBench's).

    `state.info` has goal (the goal's observation), target (the cubes' positions), task (an id from
    1, USER_TASK or NO_TASK), success and diverged (bool), and senses (the state of `reality`; None
    without one). All methods are for a single environment: vmap them.

    Raises UserError if `reward` is not a key of `envs.rewards.REWARDS`.
    """

    def __init__(
        self,
        spec: EnvSpec,
        physics: Physics,
        reality: Reality | None = None,
        reward: str = "sparse",
    ):
        self.spec = spec
        self.physics = physics
        self.reality = reality
        self.scene = physics.scene
        self.layout = terms.layout(spec.num_cubes, spec.unobserved)
        self._reward = lookup("reward", REWARDS, reward)
        self._start = jnp.array([task.start_xyz for task in spec.tasks], jnp.float32)
        self._goal = jnp.array([task.goal_xyz for task in spec.tasks], jnp.float32)
        self._jitter = jnp.array([task.jitter for task in spec.tasks], jnp.float32)

    @property
    def space(self) -> Space:
        """What an agent observes here, and how it acts."""
        return Space(self.layout, self.action_size)

    @property
    def observation_size(self) -> int:
        """The length of the observation."""
        return self.layout.size

    @property
    def action_size(self) -> int:
        """The length of the action."""
        return ACTION_SIZE

    @property
    def backend(self) -> str:
        """The physics engine's name."""
        return self.physics.name

    @property
    def num_tasks(self) -> int:
        """The number of evaluation tasks, whose ids are 1 to `num_tasks`."""
        return len(self.spec.tasks)

    @property
    def episode_length(self) -> int:
        """The number of control steps after which an evaluation episode has failed."""
        return self.spec.episode_length

    def check_task(self, task: TaskId) -> None:
        """Raise `UserError` if there is no task with that id."""
        if not 1 <= task <= self.num_tasks:
            raise UserError(f"task is {task}: {self.spec.name} has tasks 1 to {self.num_tasks}")

    @jax_defaults()
    def reset(self, rng: PRNGKeyArray) -> State:
        """Start a task drawn at random."""
        task_key, key = jax.random.split(rng)
        return self.reset_task(key, jax.random.randint(task_key, (), 1, self.num_tasks + 1))

    @jax_defaults()
    def reset_task(self, key: PRNGKeyArray, task: TaskId) -> State:
        """Start the task with that id, with the cubes permuted and their starts shifted at random.

        Raises `UserError` if there is no such id. A traced id cannot be refused: the nearest task
        starts, and `info` has the task NO_TASK.
        """
        if not isinstance(task, Tracer):
            self.check_task(task)
        order_key, key = jax.random.split(key)
        order = jax.random.permutation(order_key, self.spec.num_cubes)
        task = jnp.asarray(task, jnp.int32)
        nearest = jnp.clip(task, 1, self.num_tasks)
        start, goal = self._start[nearest - 1], self._goal[nearest - 1]
        state = self.reset_to(key, start[order], goal[order], jitter=self._jitter[nearest - 1])
        return replace(state, info=state.info | {"task": jnp.where(task == nearest, task, NO_TASK)})

    @jax_defaults()
    def reset_to(
        self,
        key: PRNGKeyArray,
        start: Float[ArrayLike, "cube 3"],
        goal: Float[ArrayLike, "cube 3"],
        *,
        yaw: Float[ArrayLike, "cube"] | None = None,
        jitter: Float[ArrayLike, "2"] | float = START_JITTER,
    ) -> State:
        """Start with the cubes near `start` and their targets at `goal`, in metres.

        As in OGBench, the goal's observation is that of the goal scene after two random steps, with
        the arm in a random pose. Start positions are shifted in x and y by up to `jitter` metres.
        Cubes start at `yaw`, radians, random by default.
        """
        goal_key, arm_key, jitter_key, yaw_key = jax.random.split(key, 4)
        start, goal = jnp.asarray(start, jnp.float32), jnp.asarray(goal, jnp.float32)
        goal_state = self._settled(goal_key, goal)
        shift = jitter * jax.random.uniform(jitter_key, start[:, :2].shape, minval=-1.0)
        if yaw is None:
            yaw = jax.random.uniform(yaw_key, (self.spec.num_cubes,), maxval=2 * jnp.pi)
        physics_state = self._place(arm_key, start.at[:, :2].add(shift), jnp.asarray(yaw))
        world = self.begin(key, physics_state)
        return self._first(world, self.observe(goal_state), goal)

    @jax_defaults()
    def random_scene(self, key: PRNGKeyArray) -> PhysicsState:
        """A scene without a task, for data collection: cubes at random places on the table."""
        arm_key, cube_key, yaw_key = jax.random.split(key, 3)
        xy = workspace.CUBE.sample(cube_key, (self.spec.num_cubes,))
        height = jnp.full((self.spec.num_cubes, 1), CUBE_HALF_SIZE)
        yaw = jax.random.uniform(yaw_key, (self.spec.num_cubes,), maxval=2 * jnp.pi)
        return self._place(arm_key, jnp.concatenate([xy, height], axis=-1), yaw)

    @jax_defaults()
    def step(self, state: State, action: Float[ArrayLike, "action"]) -> State:
        """One control step of 0.05 s. A state that is done does not change."""
        world = World(self.simulation(state), state.info["senses"])
        return self._next(state, self.advance(world, action, active=state.done == 0))

    @jax_defaults()
    def begin(self, key: PRNGKeyArray, physics_state: PhysicsState) -> World:
        """The world of an episode that starts from a simulation at rest."""
        if self.reality is None:
            return World(physics_state, None)
        key = jax.random.fold_in(key, _REALITY)
        return sensing.begin(key, self.reality, self.scene, physics_state)

    @jax_defaults()
    def advance(
        self, world: World, action: Float[ArrayLike, "action"], active: Bool[ArrayLike, ""] = True
    ) -> World:
        """One control step of a world; a world that is not active does not change."""
        if self.reality is None or world.senses is None:
            return World(self.simulate(world.physics, action, active), None)
        senses, due = sensing.act(world.senses, jnp.asarray(action))
        physics_state = self.simulate(world.physics, due, active)
        senses = sensing.look(self.reality, self.scene, senses, physics_state)
        senses = trees.where(active, senses, world.senses)
        return World(physics_state, senses)

    @staticmethod
    def simulation(state: State) -> PhysicsState:
        """The simulation of a state, which is where Brax keeps its own engines' states."""
        return state.pipeline_state  # pyright: ignore[reportReturnType]

    def perceive(self, world: World) -> PhysicsState:
        """The simulation of a world as the policy perceives it."""
        return sensing.perceived(self.scene, world)

    @jax_defaults()
    def simulate(
        self,
        physics_state: PhysicsState,
        action: Float[ArrayLike, "action"],
        active: Bool[ArrayLike, ""] = True,
    ) -> PhysicsState:
        """One control step of the bare simulation, without a task; see `Physics.step`."""
        ctrl = control.servo_targets(self.scene, physics_state, jnp.asarray(action))
        return self.physics.step(physics_state, ctrl, active)

    @jax_defaults()
    def observe(self, physics_state: PhysicsState) -> Float[Array, "observation"]:
        """The observation of a bare simulation."""
        return observation.observe(self.layout, self.scene, physics_state)

    def _settled(self, key: PRNGKeyArray, cubes: Float[Array, "cube 3"]) -> PhysicsState:
        arm_key, action_key = jax.random.split(key)
        physics_state = self._place(arm_key, cubes, jnp.zeros(self.spec.num_cubes))
        actions = jax.random.uniform(
            action_key, (SETTLING_STEPS, ACTION_SIZE), minval=-1.0, maxval=1.0
        )
        return jax.lax.scan(
            lambda state, action: (self.simulate(state, action), None), physics_state, actions
        )[0]

    def _place(
        self, arm_key: PRNGKeyArray, cubes: Float[Array, "cube 3"], yaw: Float[Array, "cube"]
    ) -> PhysicsState:
        """A scene at rest: the arm in a random pose, the cubes at given positions and yaws."""
        pos_key, yaw_key = jax.random.split(arm_key)
        home = jnp.array(self.scene.home_qpos, jnp.float32)
        joints = kinematics.inverse(
            workspace.PINCH_START.sample(pos_key),
            jax.random.uniform(yaw_key, minval=-jnp.pi, maxval=jnp.pi),
            near=home[self.scene.arm],
        )
        poses = jnp.concatenate([cubes, yaw_quat(yaw)], axis=-1)
        qpos = home.at[self.scene.arm].set(joints).at[self.scene.cubes_qpos].set(poses.ravel())
        return self.physics.init(qpos)

    def _first(
        self, world: World, goal: Float[Array, "observation"], target: Float[Array, "cube 3"]
    ) -> State:
        zero, no = jnp.zeros(()), jnp.zeros((), bool)
        return State(
            pipeline_state=world.physics,  # pyright: ignore[reportArgumentType]
            obs=self.observe(self.perceive(world)),
            reward=zero,
            done=zero,
            metrics={"success": zero},
            info={
                "goal": goal,
                "target": target,
                "task": jnp.full((), USER_TASK, jnp.int32),
                "success": no,
                "diverged": no,
                "senses": world.senses,
            },
        )

    def _next(self, state: State, world: World) -> State:
        physics_state = world.physics
        positions, _ = cube_poses(self.scene, physics_state)
        target = state.info["target"]
        placed = jnp.linalg.norm(positions - target, axis=-1) <= self.spec.success_distance
        diverged = physics_state.diverged
        success = jnp.all(placed) & ~diverged
        situation = Situation(physics_state.pinch_pos, positions, target, placed, success)
        return replace(
            state,
            pipeline_state=physics_state,
            obs=self.observe(self.perceive(world)),
            reward=self._reward(situation),
            done=(success | diverged).astype(jnp.float32),
            metrics=state.metrics | {"success": success.astype(jnp.float32)},
            info=state.info | {"success": success, "diverged": diverged, "senses": world.senses},
        )
