"""Measurements of an accelerator: simulation, generation, evaluation, training and parity."""

import itertools
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from pigbench import agents, devices, envs
from pigbench.bench import picking, simulation, training
from pigbench.bench.budget import FIRST, RATE, Row, RowResult
from pigbench.bench.sizes import Sizes
from pigbench.bench.timing import Contender, alternate
from pigbench.envs.physics import ENGINES
from pigbench.provenance import package_versions, surroundings

PACKAGES = ("jaxlib", "mujoco-mjx", "warp-lang", "flax", "optax", "brax")

# MJX in JAX compiles for minutes, longer with every possible contact: one pad box per finger.
_PROFILES = {"mjx-jax": "fast"}
# Estimated seconds per row before one of its kind has been measured; mostly compilation.
_SECONDS = {"mjx-warp": 30.0, "mujoco": 15.0, "mjx-jax": 180.0}
_OTHER_SECONDS = 30.0  # of trainings, and of other engines
_ON_CPU = (1, 16)  # simulations at once for the engines that are slow there
_DEFAULT = "default"  # precision of matrix products


def rows(sizes: Sizes) -> list[Row]:
    """The rows to measure, the most informative first."""
    default = envs.default_engine()
    engines = sizes.engines or (default, *(name for name in ENGINES if name != default))
    first, *others = engines
    main, *further = sizes.environments
    return [
        *_steps(sizes, main, first),
        *_trainings(sizes, "paper", sizes.seeds, _DEFAULT),
        # C beside the engine: it does not place every cube either.
        *(_parity(sizes, main, engine) for engine in dict.fromkeys([first, "mujoco"])),
        _generation(sizes, main, first),
        _evaluation(sizes, main, first),
        *(row for name in further for row in _steps(sizes, name, first)),
        *(row for name in sizes.precisions for row in _trainings(sizes, "paper", (1,), name)),
        *_trainings(sizes, "cpu", sizes.cpu_seeds, _DEFAULT),
        *(
            row
            for name in sizes.precisions
            for row in _trainings(sizes, "paper", sizes.seeds[1:], name)
        ),
        *(
            row
            for engine in others
            for row in (
                *_steps(sizes, main, engine),
                *([_parity(sizes, main, engine)] if engine != "mujoco" else []),
                *(row for name in further for row in _steps(sizes, name, engine)),
            )
        ),
    ]


def _steps(sizes: Sizes, environment: str, engine: str) -> list[Row]:
    slow = devices.backend() == "cpu" and engine != "mujoco"
    return [
        _row(
            "steps",
            count,
            _simulated(environment, engine),
            lambda count=count: _timed(
                lambda: simulation.steps(_make(environment, engine), count, name=engine), sizes
            ),
        )
        for count in (_ON_CPU if slow else sizes.simulations)
    ]


def _generation(sizes: Sizes, environment: str, engine: str) -> Row:
    return _row(
        "generation",
        sizes.generation,
        _simulated(environment, engine),
        lambda: _timed(
            lambda: simulation.generation(
                _make(environment, engine), sizes.generation, name=engine
            ),
            sizes,
        ),
    )


def _evaluation(sizes: Sizes, environment: str, engine: str) -> Row:
    return _row(
        "evaluation",
        sizes.episodes,
        _simulated(environment, engine),
        lambda: _timed(
            lambda: simulation.evaluation(
                _make(environment, engine), sizes.episodes, sizes.methods[0], "paper", name=engine
            ),
            sizes,
            turns=1,  # a unit consists of whole episodes
        ),
    )


def _parity(sizes: Sizes, environment: str, engine: str) -> Row:
    def measure() -> RowResult:
        env = _make(environment, engine)
        picks = picking.pick_and_place(env, sizes.picks)
        errors = picking.step_errors(env, picks)
        return {
            "placed": float(picks.placed.mean()),
            "distance_mm": 1e3 * float(np.median(picks.distances)),
            "arm_rad": float(errors.arm.max()),
            "cube_mm_median": 1e3 * float(np.median(errors.cube)),
            "cube_mm_95": 1e3 * float(np.quantile(errors.cube, 0.95)),
            "cube_mm_max": 1e3 * float(errors.cube.max()),
        }

    return _row("parity", sizes.picks, _simulated(environment, engine), measure)


def _trainings(sizes: Sizes, preset: str, seeds: tuple[int, ...], precision: str) -> list[Row]:
    def measure(method: str, count: int) -> RowResult:
        env = _make(sizes.environments[0], "mujoco")  # only for its array sizes
        config = agents.get(method).preset(preset)
        with jax.default_matmul_precision(precision):
            return _timed(
                lambda: training.updates(env, training.noise(env), method, config, seeds=count),
                sizes,
            )

    return [
        _row(
            f"training {preset}",
            count,
            {"method": method, "preset": preset, "precision": precision},
            lambda method=method, count=count: measure(method, count),
        )
        for count, method in itertools.product(seeds, sizes.methods)
    ]


def _row(kind: str, size: int, labels: Mapping[str, str], measure: Callable[[], RowResult]) -> Row:
    engine = labels.get("engine")
    return Row(
        kind=f"{kind} {engine}" if engine else kind,
        series=" ".join([kind.split()[0], *labels.values()]),
        size=size,
        labels={"what": kind.split()[0], **labels, "size": size},
        measure=lambda: _with_memory(measure),
        seconds=_SECONDS.get(engine or "", _OTHER_SECONDS),
    )


def _simulated(environment: str, engine: str) -> dict[str, str]:
    return {"environment": environment, "engine": engine, "profile": _profile(engine)}


def _profile(engine: str) -> str:
    return _PROFILES.get(engine, "exact")


def _make(environment: str, engine: str) -> "envs.CubeEnv":
    return envs.make(environment, engine=engine, profile=_profile(engine))


def _timed(make: Callable[[], Contender], sizes: Sizes, *, turns: int = 3) -> RowResult:
    """Items per second, and the seconds of setup and of the first unit, which compiles."""
    begin = time.perf_counter()
    contender = make()
    setup = time.perf_counter() - begin
    timing = alternate([contender], turns=turns, seconds=sizes.seconds)[contender.name]
    unit = timing.median * contender.items
    return {
        RATE: 1 / timing.median,
        "unit_ms": 1e3 * unit,
        "compile_s": max(0.0, timing.first - unit),
        FIRST: setup + timing.first,
    }


def _with_memory(measure: Callable[[], RowResult]) -> RowResult:
    before = _peak()
    result = measure()
    after = _peak()
    # JAX keeps one peak per process: it belongs to this row only if this row raised it.
    mine = after if after is not None and after != before else None
    return {**result, "jax_mb": _megabytes(mine), "card_mb": _megabytes(_used())}


def _peak() -> int | None:
    """Peak bytes in use by JAX; None where it does not count them."""
    stats = jax.local_devices()[0].memory_stats()
    return stats.get("peak_bytes_in_use") if stats else None


def _used() -> int | None:
    """Bytes in use on the card by any process, from Warp; None without Warp or a card."""
    warp = sys.modules.get("warp")  # only if an engine has imported it
    try:
        if warp is None or not warp.is_cuda_available():
            return None
        device = warp.get_device("cuda:0")
        return device.total_memory - device.free_memory
    except Exception:  # no error here is a reason to lose a measurement
        return None


def _megabytes(size: int | None) -> float | None:
    return None if size is None else size / 1e6


def alive() -> bool:
    """Whether the device still computes: an error in one program can break all others."""
    try:
        return bool(jnp.ones(8).sum() == 8)
    except Exception:  # the device's errors are of many types
        return False


def machine() -> dict[str, Any]:
    """Versions, commit, machine and accelerator, ready for JSON."""
    origin = surroundings()
    return origin | {
        "versions": origin["versions"] | package_versions(PACKAGES),
        "accelerator": {
            "kind": jax.devices()[0].device_kind,
            "platform": jax.devices()[0].platform,
            "nvidia": _nvidia(),
        },
    }


def _nvidia() -> str | None:
    """Name, driver and memory of each NVIDIA card, one line per card; None where there is none."""
    query = ["nvidia-smi", "--query-gpu=name,driver_version,memory.total", "--format=csv,noheader"]
    try:
        return subprocess.run(
            query, capture_output=True, check=True, text=True, timeout=20
        ).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
