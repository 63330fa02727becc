"""How long a call into Python takes, and what a control step takes besides the engine."""

import functools
import statistics
import time

import jax
import jax.numpy as jnp
from mujoco.batch import Batch

from pigbench import envs
from pigbench.bench.simulation import generation
from pigbench.support.host_calls import host_call

SIMULATIONS, TURNS, CHUNK = 50, 9, 10


def milliseconds(work) -> float:
    """The duration of `work()`."""
    begin = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - begin)


def loop(call):
    """A hundred calls with ten arrays, of which eight come back."""

    def step(arrays, _):
        return [*call(*arrays), *arrays[8:]], None

    run = jax.jit(lambda arrays: jax.lax.scan(step, arrays, length=100)[0])
    return lambda: jax.block_until_ready(run([jnp.ones((SIMULATIONS, 26))] * 10))


def eight(*arrays):
    """The first eight of the arrays."""
    return list(arrays[:8])


SHAPES = [jax.ShapeDtypeStruct((SIMULATIONS, 26), jnp.float32)] * 8
CALLS = {
    "host_call": loop(functools.partial(host_call, "eight", eight, SHAPES)),
    "pure_callback": loop(functools.partial(jax.pure_callback, eight, SHAPES)),
}
for work in CALLS.values():
    work()
taken = {name: [] for name in CALLS}
for _ in range(TURNS):
    for name, work in CALLS.items():
        taken[name].append(milliseconds(work) / 100)
for name, times in taken.items():
    print(f"{name}: {statistics.median(times):.2f} ms")

in_engine = 0.0
step_in_c = Batch.step


def timed_step(*args, **options):
    """`Batch.step`, timed."""
    global in_engine
    begin = time.perf_counter()
    try:
        step_in_c(*args, **options)
    finally:
        in_engine += 1000 * (time.perf_counter() - begin)


Batch.step = timed_step
env = envs.make("cube-double")
env.physics.batches_at_once = 1  # for the engine's time to be a share of the whole
contender = generation(env, SIMULATIONS, name="pigbench")
contender.work(1)
whole, engine = [], []
for _ in range(TURNS):
    in_engine = 0.0
    whole.append(milliseconds(lambda: contender.work(5)) / (5 * CHUNK))
    engine.append(in_engine / (5 * CHUNK))
shares = sorted(part / all_ for part, all_ in zip(engine, whole, strict=True))
print(f"control step: {statistics.median(whole):.1f} ms, engine {statistics.median(engine):.1f} ms")
print(f"share of the engine: {shares[0]:.3f} to {shares[-1]:.3f}, {statistics.median(shares):.3f}")
