"""Simulation, timed: data generation, evaluation, and bare control steps."""

# mujoco's compiled modules carry no types.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Shaped
from mujoco.batch import Batch

from pigbench import envs, seeds
from pigbench.bench.timing import Contender
from pigbench.bench.training import untrained
from pigbench.data import collect
from pigbench.data.collect import Simulation
from pigbench.envs.control import servo_targets
from pigbench.envs.oracles import POLICIES
from pigbench.envs.physics import PhysicsState
from pigbench.envs.scene import SUBSTEPS
from pigbench.errors import UserError
from pigbench.evaluation.rollouts import make_evaluator
from pigbench.evaluation.settings import Evaluation
from pigbench.support import cores

_CHUNK = 10  # control steps per call
_WHOLE = 0.98  # least share of an evaluation's control steps that must be run
_BEFORE = 50  # control steps after which the grippers are in contact with cubes

Controls = Float[Array, "simulation nu"]
Run = Callable[[Simulation], tuple[Simulation, dict[str, Shaped[Array, "time simulation ..."]]]]
Advance = Callable[[PhysicsState, Controls], object]
"""A control step of a batch of states under given controls."""


def generation(env: "envs.CubeEnv", simulations: int, *, name: str) -> Contender:
    """Collect play data without writing it; an item is one simulation's control step.

    As `collect.local_source` does, with so many simulations in each of the engine's batches.
    """
    run, start = _under_way(env, simulations)
    batches = env.physics.batches_at_once

    def collect_one(count: int) -> None:
        for _ in range(count):
            jax.device_get(run(start)[1])

    def work(count: int) -> None:
        with ThreadPoolExecutor(batches) as threads:
            list(threads.map(collect_one, [count] * batches))

    return Contender(name, work, items=batches * simulations * _CHUNK)


def engine(env: "envs.CubeEnv", simulations: int, *, name: str) -> Contender:
    """The engine alone, on the states of `generation`, with the same items.

    In C this is MuJoCo's own batch of simulations, filled with the states of each step.
    """
    policy = POLICIES["play"](env.spec, env.scene)
    _, start = _under_way(env, simulations)

    def record(batch: Simulation, _: None):
        after, rows = jax.vmap(lambda one: collect.step(env, policy, one))(batch)
        controls = jax.vmap(lambda *x: servo_targets(env.scene, *x))(
            batch.world.physics, rows["actions"]
        )
        return after, (batch.world.physics, controls)

    _, recorded = jax.jit(lambda batch: jax.lax.scan(record, batch, length=_CHUNK))(start)
    steps = [jax.tree.map(lambda x: x[time], recorded) for time in range(_CHUNK)]  # noqa: B023
    advance = _in_c(env, simulations) if env.backend == "mujoco" else _compiled(env)

    def work(count: int) -> None:
        for _ in range(count):
            for states, controls in steps:
                advance(states, controls)

    return Contender(name, work, items=simulations * _CHUNK)


def _under_way(env: "envs.CubeEnv", simulations: int) -> tuple[Run, Simulation]:
    """A function that collects a chunk of play data, and the simulations to start it from."""
    policy = POLICIES["play"](env.spec, env.scene)
    run = jax.jit(lambda batch: collect.run(env, policy, batch, steps=_CHUNK))
    begin = jax.jit(jax.vmap(lambda key: collect.begin(env, policy, key, jnp.zeros((), bool))))
    start = begin(jax.random.split(seeds.key(0), simulations))
    for _ in range(_BEFORE // _CHUNK):
        start, _ = run(start)
    return run, start


def _in_c(env: "envs.CubeEnv", simulations: int) -> Advance:
    batch = Batch(env.scene.model, simulations, cores.available())

    def advance(states: PhysicsState, controls: Controls) -> None:
        batch.qpos[:], batch.qvel[:] = states.qpos, states.qvel
        batch.qacc_warmstart[:], batch.ctrl[:] = states.warmstart, controls
        batch.step(np.arange(simulations), nstep=SUBSTEPS)

    return advance


def _compiled(env: "envs.CubeEnv") -> Advance:
    step = jax.jit(jax.vmap(env.physics.step))
    return lambda states, controls: jax.block_until_ready(step(states, controls))


def evaluation(
    env: "envs.CubeEnv", episodes: int, method: str, preset: str, *, name: str
) -> Contender:
    """Whole evaluations of a method's untrained policy; an item is one episode's control step."""
    agent, params = untrained(env, method, preset)
    evaluate = make_evaluator(env, agent, Evaluation(episodes))
    steps = env.num_tasks * episodes * env.episode_length

    def work(count: int) -> None:
        for _ in range(count):
            outcome = evaluate(params, lambda _: None)
            if outcome["length"].sum() < _WHOLE * steps:
                raise UserError(
                    f"episodes of {env.spec.name} end early under an untrained policy, so they do "
                    "not tell the time of a control step: choose another environment"
                )

    return Contender(name, work, items=steps)


def steps(env: "envs.CubeEnv", simulations: int, *, name: str) -> Contender:
    """Control steps of tasks under random actions; an item is one simulation's control step."""
    key = seeds.key(0)
    states = jax.jit(jax.vmap(env.reset))(jax.random.split(key, simulations))

    @jax.jit
    def advance(states, count):
        def body(number, states):
            shape = (simulations, env.action_size)
            actions = jax.random.uniform(jax.random.fold_in(key, number), shape, minval=-1.0)
            return jax.vmap(env.step)(states, actions)

        return jax.lax.fori_loop(0, count, body, states)

    def work(count: int) -> None:
        nonlocal states
        states = jax.block_until_ready(advance(states, count))

    return Contender(name, work, items=simulations)
