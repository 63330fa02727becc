"""What is timed of an environment: its control steps, many simulations at once."""

import jax

from pigbench.bench.timing import Contender
from pigbench.envs import CubeEnv


def steps(env: CubeEnv, simulations: int, *, name: str) -> Contender:
    """Control steps of tasks under random actions; an item is one simulation's step."""
    key = jax.random.key(0)

    @jax.jit
    def begin() -> object:
        return jax.vmap(env.reset)(jax.random.split(key, simulations))

    @jax.jit
    def advance(states, count):
        def body(number, states):
            actions = jax.random.uniform(
                jax.random.fold_in(key, number), (simulations, env.action_size), minval=-1.0
            )
            return jax.vmap(env.step)(states, actions)

        return jax.lax.fori_loop(0, count, body, states)

    states = begin()

    def work(count: int) -> None:
        nonlocal states
        states = jax.block_until_ready(advance(states, count))

    return Contender(name, work, items=simulations)
