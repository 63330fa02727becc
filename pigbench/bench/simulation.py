"""What is timed of simulations: data generation, evaluation, and bare control steps."""

import jax
import jax.numpy as jnp

from pigbench import agents
from pigbench.bench.timing import Contender
from pigbench.bench.training import standard
from pigbench.data import collect
from pigbench.envs import CubeEnv
from pigbench.envs.oracles import POLICIES
from pigbench.training.evaluate import Evaluation, make_evaluator
from pigbench.training.restore import agent_for

_CHUNK = 10  # control steps a call
_WHOLE = 0.98  # share of an evaluation's control steps, at least


def generation(env: CubeEnv, simulations: int, *, name: str) -> Contender:
    """Play data, up to where it would be written: an item is one simulation's control step."""
    policy = POLICIES["play"](env.scene)
    keys = jax.random.split(jax.random.key(0), simulations)
    run = jax.jit(lambda batch: collect.run(env, policy, batch, steps=_CHUNK))
    batch = jax.jit(jax.vmap(lambda key: collect.begin(env, policy, key, jnp.zeros((), bool))))(
        keys
    )

    def work(count: int) -> None:
        nonlocal batch
        for _ in range(count):
            batch, rows = run(batch)
            jax.device_get(rows)

    return Contender(name, work, items=simulations * _CHUNK)


def evaluation(env: CubeEnv, episodes: int, method: str, preset: str, *, name: str) -> Contender:
    """Whole evaluations of a method's fresh policy: an item is one episode's control step."""
    agent = agent_for(env, method, agents.get(method).preset(preset), standard(env))
    params = agents.create(agent, jax.random.key(0)).params
    evaluate = make_evaluator(env, agent, Evaluation(episodes))
    steps = env.num_tasks * episodes * env.episode_length

    def work(count: int) -> None:
        for _ in range(count):
            outcome = evaluate(params, lambda _: None)
            # A fresh policy reaches no goal: episodes have their whole length, but for those whose
            # simulation diverges.
            assert outcome["length"].sum() >= _WHOLE * steps

    return Contender(name, work, items=steps)


def steps(env: CubeEnv, simulations: int, *, name: str) -> Contender:
    """Control steps of tasks under random actions: an item is one simulation's."""
    key = jax.random.key(0)
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
