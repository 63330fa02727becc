"""How control steps scale with simultaneous simulations and with cubes, in time and in memory."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp

from pigbench import envs
from pigbench.bench.timing import Timing
from pigbench.errors import UserError
from pigbench.report import canvas, styles

_PANEL = 3.2, 2.4  # inches


class Point(NamedTuple):
    """One measurement: a number of simultaneous simulations of an environment."""

    environment: str
    simulations: int

    @property
    def name(self) -> str:
        """Both as text."""
        return f"{self.environment}, {self.simulations:,}"

    @property
    def cubes(self) -> int:
        """Cubes in the environment."""
        return envs.SPECS[self.environment].num_cubes


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


def draw(
    by_simulations: Mapping[Point, Timing], by_cubes: Mapping[Point, Timing], path: Path
) -> None:
    """Plot control steps per second over simulations and over cubes into the file `path`."""
    with canvas.look():
        figure, panels = canvas.grid(1, 2, panel=_PANEL, legend=[])
        left, right = panels[0]
        for panel, timings, what in (
            (left, by_simulations, "simulations"),
            (right, by_cubes, "cubes"),
        ):
            counts = [getattr(point, what) for point in timings]
            rates = [1 / timing.median for timing in timings.values()]
            panel.plot(counts, rates, marker="o", color=styles.BLUE)
            panel.set_xscale("log", base=2)
            panel.set_xticks(counts, labels=[f"{count:,}" for count in counts])
            panel.set_xlabel(what)
        left.set_ylim(bottom=0)  # for both panels
        left.set_title(next(iter(by_simulations)).environment)
        right.set_title(f"{next(iter(by_cubes)).simulations:,} simulations")
        left.set_ylabel("control steps per second")
        canvas.save(figure, path)
