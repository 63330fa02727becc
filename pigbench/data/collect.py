"""Generation of an offline data set: a scripted policy in many simulations, shard by shard."""

import math
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Future,
    ThreadPoolExecutor,
    wait,
)
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Key, Shaped

from pigbench import envs, seeds
from pigbench.data.manifest import Shard, Spec
from pigbench.data.shard import DTYPES, FieldArray
from pigbench.data.writer import Writer
from pigbench.envs.oracles import ScriptedPolicy
from pigbench.envs.physics import warn_of_overflow
from pigbench.envs.reality.sensing import World
from pigbench.settings import jax_defaults
from pigbench.support import files
from pigbench.support.progress import Progress

COMPACT = ("observations", "actions", "terminals")
"""The fields that methods train on."""
FIELDS = (*COMPACT, "qpos", "qvel")
_LIVE = "live"  # field: whether a row belongs to the episode
_LONGEST_CHUNK = 100  # control steps between two progress reports


class Episodes(NamedTuple):
    """The episodes of a shard that did not diverge."""

    arrays: dict[str, FieldArray]  # one episode after another
    dropped: int


ShardSimulator = Callable[[Shard, Callable[[int], object]], Episodes]
"""Simulates a shard; calls its second argument with the number of further control steps done."""

Tell = Callable[[Shard, int], object]
"""Called, in any thread, with a shard and the number of its further control steps that are done."""

Source = Callable[[Sequence[Shard], Tell], Iterator[tuple[Shard, Episodes]]]
"""Simulates shards and yields them in any order."""


class Simulation(NamedTuple):
    """One episode in progress. A vacant one pads the last shard's batch and is never stepped."""

    key: Key[Array, ""]
    world: World
    memory: Any  # the policy's
    vacant: Bool[Array, ""]
    over: Bool[Array, ""]  # whether the policy ended the episode in an earlier row


def write_missing(
    env: "envs.CubeEnv",
    policy: ScriptedPolicy,
    spec: Spec,
    writer: Writer,
    source: Source,
) -> None:
    """Write every shard that the data set still lacks, simulated by `source`.

    Raises UserError if the disk has no room for them.
    """
    missing = writer.missing()
    most = most_rows(policy, spec.rows_per_episode)
    total = sum(shard.episodes for shard in spec.plan()) * most
    remaining = sum(shard.episodes for shard in missing) * most
    require_room(env, spec.fields, remaining, writer.folder)
    dropped = 0
    with Progress("generate", total=total, unit="transitions", done=total - remaining) as progress:

        def tell(shard: Shard, steps: int) -> None:
            note = f"{shard.name}, {dropped} episodes dropped"
            progress.advance(shard.episodes * steps, note)

        for shard, episodes in source(missing, tell):
            dropped += episodes.dropped
            writer.write(shard, episodes.arrays, dropped=episodes.dropped)


def local_source(env: "envs.CubeEnv", policy: ScriptedPolicy, spec: Spec) -> Source:
    """Simulate shards on this machine, as many at once as the engine can use."""

    def simulated(shards: Sequence[Shard], tell: Tell) -> Iterator[tuple[Shard, Episodes]]:
        simulate = simulator(env, policy, spec)
        stopped = threading.Event()

        @jax_defaults()  # which are each thread's own
        def simulate_one(shard: Shard) -> tuple[Shard, Episodes]:
            def tell_of_shard(steps: int) -> None:
                if stopped.is_set():
                    raise CancelledError
                tell(shard, steps)

            return shard, simulate(shard, tell_of_shard)

        threads = ThreadPoolExecutor(env.physics.batches_at_once, "simulate")
        waiting = iter(shards)

        def begin_more(count: int) -> set[Future[tuple[Shard, Episodes]]]:
            return {threads.submit(simulate_one, shard) for shard in islice(waiting, count)}

        running = begin_more(env.physics.batches_at_once)
        try:
            while running:
                ended, running = wait(running, return_when=FIRST_COMPLETED)
                running |= begin_more(len(ended))
                for one in ended:
                    yield one.result()
        finally:
            stopped.set()
            threads.shutdown(wait=False)

    return simulated


def simulator(env: "envs.CubeEnv", policy: ScriptedPolicy, spec: Spec) -> ShardSimulator:
    """A simulator of the shards of `spec`.

    A shard's episodes depend only on the seed, the shard's number and their place in it; those
    whose simulation diverged are dropped and counted.
    """
    simulations_at_once = spec.episodes_per_shard
    assert isinstance(simulations_at_once, int), "only imported data have unequal shards"
    rows = most_rows(policy, spec.rows_per_episode)
    steps = _chunk(rows)
    place = np.arange(simulations_at_once)

    def keys_of(shard_number: int) -> Key[Array, "simulation"]:
        shard_key = jax.random.fold_in(seeds.key(spec.seed), shard_number)
        return jax.vmap(partial(jax.random.fold_in, shard_key))(place)

    # Compiled before threads use them, since otherwise each of them would compile them.
    start = jax.jit(jax.vmap(partial(begin, env, policy))).lower(keys_of(0), place >= 0)
    begin_all = start.compile()
    run_chunk = jax.jit(partial(run, env, policy, steps=steps)).lower(start.out_info).compile()

    def simulate(shard: Shard, tell: Callable[[int], object]) -> Episodes:
        simulations = begin_all(keys_of(shard.number), place >= shard.episodes)
        chunks = []
        for _ in range(rows // steps):
            simulations, chunk = run_chunk(simulations)
            stored = {field: chunk[field] for field in (*spec.fields, _LIVE) if field in chunk}
            chunks.append(jax.device_get(stored))
            tell(steps)
        physics = simulations.world.physics
        warn_of_overflow(physics)
        kept = ~np.asarray(simulations.vacant | physics.diverged)
        return Episodes(_episodes(chunks, kept), shard.episodes - int(kept.sum()))

    return simulate


def most_rows(policy: ScriptedPolicy | type[ScriptedPolicy], rows: int) -> int:
    """The most rows of an episode: the policy's own limit if it has one, else `rows`."""
    return policy.ability.episode_rows or rows


def require_room(env: "envs.CubeEnv", fields: Iterable[str], rows: int, folder: Path) -> None:
    """Raise UserError unless the disk of `folder` has room for so many rows."""
    shapes = row_shapes(env)
    row = sum(math.prod(shapes[field]) * DTYPES[field].itemsize for field in fields)
    files.require_room(folder, rows * row)


def row_shapes(env: "envs.CubeEnv") -> dict[str, tuple[int, ...]]:
    """The shape of one row of each field."""
    return {
        "observations": (env.observation_size,),
        "actions": (env.action_size,),
        "terminals": (),
        "qpos": (env.scene.model.nq,),
        "qvel": (env.scene.model.nv,),
    }


def _chunk(rows: int) -> int:
    """The largest number of steps, up to `_LONGEST_CHUNK`, that divides an episode."""
    return max(steps for steps in range(1, _LONGEST_CHUNK + 1) if rows % steps == 0)


def begin(
    env: "envs.CubeEnv", policy: ScriptedPolicy, key: Key[Array, ""], vacant: Bool[Array, ""]
) -> Simulation:
    """An episode at its start: a random scene and the policy's first plan for it."""
    scene_key, policy_key, key = jax.random.split(key, 3)
    # One key for both, since `env.begin` folds a constant into it before it draws.
    world = env.begin(scene_key, env.random_scene(scene_key))
    memory = policy.reset(policy_key, env.perceive(world))
    return Simulation(key, world, memory, vacant, jnp.zeros((), bool))


def run(
    env: "envs.CubeEnv", policy: ScriptedPolicy, simulations: Simulation, *, steps: int
) -> tuple[Simulation, dict[str, Shaped[Array, "{steps} simulation ..."]]]:
    """Advance a batch of simulations; also returns the rows by field."""
    one = partial(step, env, policy)
    return jax.lax.scan(lambda batch, _: jax.vmap(one)(batch), simulations, length=steps)


def step(
    env: "envs.CubeEnv", policy: ScriptedPolicy, simulation: Simulation
) -> tuple[Simulation, dict[str, Shaped[Array, "..."]]]:
    """Do one control step; also returns the row, by field, of the state and action before it."""
    key, act_key, advance_key = jax.random.split(simulation.key, 3)
    world, memory, over = simulation.world, simulation.memory, simulation.over
    seen = env.perceive(world)
    action = policy.act(act_key, memory, seen)
    after_over = over | policy.finished(memory)
    after = env.advance(world, action, active=~(simulation.vacant | after_over))
    row = {
        "observations": env.observe(seen),
        "actions": action,
        "qpos": world.physics.qpos,
        "qvel": world.physics.qvel,
        _LIVE: ~over,
    }
    memory = policy.advance(advance_key, memory, env.perceive(after))
    return Simulation(key, after, memory, simulation.vacant, after_over), row


def _episodes(
    chunks: list[dict[str, Shaped[np.ndarray, "time simulation ..."]]],
    kept: Bool[np.ndarray, "simulation"],
) -> dict[str, FieldArray]:
    """The live rows of the kept episodes, one episode after another."""

    def by_episode(field: str) -> Shaped[np.ndarray, "episode time ..."]:
        by_step = np.concatenate([chunk[field] for chunk in chunks])[:, kept]
        return np.swapaxes(by_step, 0, 1)

    live = by_episode(_LIVE)
    arrays = {
        field: np.ascontiguousarray(by_episode(field)[live])
        for field in chunks[0]
        if field != _LIVE
    }
    ends = np.cumsum(live.sum(axis=1)) - 1
    arrays["terminals"] = np.isin(np.arange(live.sum()), ends)
    return arrays
