"""Measurements of an accelerator as tables, and its control steps as a plot."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pigbench.bench.budget import FAILED, RATE, SKIPPED
from pigbench.report import styles
from pigbench.report.formats import markdown_grid
from pigbench.support.grouping import grouped

if TYPE_CHECKING:
    from matplotlib.artist import Artist

MeasuredRow = Mapping[str, Any]
"""A row's labels and its measurements, or the reason for having none."""

_PANEL = 3.2, 2.4  # inches
_SPEED = {RATE: "{}", "unit_ms": "ms per call", "compile_s": "s to compile"}
_MEMORY = {"jax_mb": "MB, JAX's peak", "card_mb": "MB, the card's", "took_s": "s in all"}
_SIMULATED = {"environment": "environment", "engine": "engine", "profile": "profile"}
# What was measured -> title, unit of the rate, and columns.
_TABLES: dict[str, tuple[str, str, dict[str, str]]] = {
    "steps": (
        "Control steps",
        "control steps per second",
        {**_SIMULATED, "size": "simulations", **_SPEED, **_MEMORY},
    ),
    "training": (
        "Updates, of all seeds together",
        "updates per second",
        {
            "method": "method",
            "preset": "preset",
            "precision": "precision",
            "size": "seeds",
            **_SPEED,
            **_MEMORY,
        },
    ),
    "parity": (
        "Picks and places, and one control step beside MuJoCo in C",
        "",
        {
            **_SIMULATED,
            "size": "cubes picked",
            "placed": "share placed",
            "distance_mm": "mm from target",
            "arm_rad": "arm, rad",
            "cube_mm_median": "cubes, mm: median",
            "cube_mm_95": "95 %",
            "cube_mm_max": "at most",
            "took_s": "s in all",
        },
    ),
    "generation": (
        "Play data",
        "transitions per second",
        {**_SIMULATED, "size": "simulations", **_SPEED, **_MEMORY},
    ),
    "evaluation": (
        "Evaluation",
        "control steps per second",
        {**_SIMULATED, "size": "episodes per task", **_SPEED, **_MEMORY},
    ),
}
_COLORS = {"mjx-warp": styles.BLUE, "mujoco": styles.BLACK, "mjx-jax": styles.VERMILLION}
_LINES = ("-", "--", "-.", ":")


def tables(machine: Mapping[str, Any], entries: Sequence[MeasuredRow]) -> str:
    """All measurements as Markdown."""
    accelerator = machine["accelerator"]
    origin = [accelerator["nvidia"] or accelerator["kind"]]
    origin += [f"{machine['machine']['cpu_count']} processors"]
    origin += [f"{name} {version}" for name, version in machine["versions"].items()]
    parts = [f"# {accelerator['kind']}", ", ".join(origin) + "."]
    for what, (title, rate, columns) in _TABLES.items():
        chosen = [entry for entry in entries if entry["what"] == what]
        if chosen:
            header = [name.format(rate) for name in columns.values()]
            lines = [[_text(entry.get(key)) for key in columns] for entry in chosen if _done(entry)]
            parts += [f"## {title}"]
            parts += [markdown_grid([header, *lines])] if lines else []
            parts += ["\n".join(_missing(entry) for entry in chosen if not _done(entry))]
    return "\n\n".join(filter(None, parts)) + "\n"


def _done(entry: MeasuredRow) -> bool:
    return FAILED not in entry and SKIPPED not in entry


def _missing(entry: MeasuredRow) -> str:
    verb = FAILED if FAILED in entry else SKIPPED
    return f"- {entry['row']}: {verb}: {entry[verb]}"


def _text(value: object) -> str:
    if value is None:
        return "–"
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
    return f"{value:,}" if isinstance(value, int) else str(value)


def draw(entries: Sequence[MeasuredRow], path: Path) -> None:
    """Plot control steps per second over simulations into the file `path`, if there are any."""
    from pigbench.report import canvas

    done = [entry for entry in entries if entry["what"] == "steps" and _done(entry)]
    curves = grouped(done, lambda entry: (entry["environment"], entry["engine"]))
    if not curves:
        return
    lines = dict(zip(dict.fromkeys(name for name, _ in curves), _LINES, strict=False))
    names = {curve: ", ".join(curve) for curve in curves}
    handles: dict[str, Artist] = {}
    with canvas.look():
        figure, panels = canvas.grid(1, 1, panel=_PANEL, legend=list(names.values()))
        panel = panels[0, 0]
        for (environment, engine), points in curves.items():
            (handles[names[environment, engine]],) = panel.plot(
                [point["size"] for point in points],
                [point[RATE] for point in points],
                marker="o",
                color=_COLORS.get(engine, styles.GREEN),
                linestyle=lines.get(environment, "-"),
            )
        canvas.log_axis(panel, "x")
        canvas.log_axis(panel, "y")
        panel.set_xlabel("simulations")
        panel.set_ylabel("control steps per second")
        canvas.add_legend(figure, handles)
        canvas.save(figure, path)
