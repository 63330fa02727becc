"""How much device memory control steps need, as counted by the compiler: nothing is run."""

import itertools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp

from pigbench import envs
from pigbench.errors import UserError
from pigbench.support.progress import Progress


class Footprint(NamedTuple):
    """Bytes that the compiled program of one control step uses, as counted by the compiler."""

    arguments: int
    results: int
    temporary: int

    @property
    def total(self) -> int:
        """The sum of all."""
        return sum(self)


def footprint(env: "envs.CubeEnv", simulations: int) -> Footprint:
    """Footprint of a control step of so many simulations. Compiles it, but runs nothing."""
    home = jnp.asarray(env.scene.home_qpos)
    one = jax.eval_shape(env.physics.init, home)
    states, actions = jax.tree.map(
        lambda x: jax.ShapeDtypeStruct((simulations, *x.shape), x.dtype),
        (one, jax.ShapeDtypeStruct((env.action_size,), jnp.float32)),
    )
    program = jax.jit(jax.vmap(env.simulate)).lower(states, actions).compile()
    sizes = program.memory_analysis()
    if sizes is None:
        raise UserError("JAX's compiler does not count memory on this device: try another")
    return Footprint(
        arguments=sizes.argument_size_in_bytes,
        results=sizes.output_size_in_bytes,
        temporary=sizes.temp_size_in_bytes,
    )


def measure(
    environment: str, simulations: Sequence[int], *, engines: Sequence[str], profile: str
) -> Mapping[tuple[str, int], Footprint]:
    """Footprints by engine and number of simulations, showing progress."""
    points = list(itertools.product(engines, simulations))
    found = {}
    with Progress("compiling", total=len(points), unit="programs") as progress:
        for engine, count in points:
            env = envs.make(environment, engine=engine, profile=profile)
            found[engine, count] = footprint(env, count)
            progress.advance(1, engine)
    return found


def table(footprints: Mapping[tuple[str, int], Footprint], *, card: float) -> list[tuple[str, ...]]:
    """One line per footprint, with the simulations that fit a card of so many GB, and a header."""
    lines = [
        (
            engine,
            f"{count:,}",
            f"{size.total / 1e6:,.1f}",
            f"{size.total / count / 1e3:,.1f}",
            f"{int(1e9 * card / size.total * count):,}",
        )
        for (engine, count), size in footprints.items()
    ]
    return [("engine", "simulations", "MB", "kB per simulation", f"fit in {card:g} GB"), *lines]
