"""Tables of success rates, as Markdown, LaTeX or CSV."""

import csv
import dataclasses
import io
import re
from collections.abc import Callable, Iterable, Mapping, Sequence

from pigbench.errors import lookup
from pigbench.report import stats
from pigbench.report.stats import Cell, Estimate, Result


@dataclasses.dataclass(frozen=True)
class Table:
    """Estimates by row and column label; `corner` names both kinds of label."""

    caption: str
    corner: tuple[str, str]
    rows: Sequence[str]
    columns: Sequence[str]
    estimates: Mapping[tuple[str, str], Estimate]


def method_table(results: Iterable[Result], *, order: Sequence[str] = ()) -> Table:
    """Methods by environments; names in `order` first, others after them by alphabet."""
    cells = stats.cells(results)
    return Table(
        caption=_caption(cells),
        corner=("method", "environment"),
        rows=ordered({cell.method for cell in cells}, order),
        columns=ordered({cell.environment for cell in cells}, order),
        estimates={cell: stats.final_success(group) for cell, group in cells.items()},
    )


def task_table(results: Iterable[Result], *, order: Sequence[str] = ()) -> Table:
    """Tasks of every environment by methods; names ordered as in `method_table`."""
    cells = stats.cells(results)
    by_task = {
        (cell.environment, task, cell.method): value
        for cell, group in cells.items()
        for task, value in stats.final_task_success(group).items()
    }
    tasks = {(environment, task) for environment, task, _ in by_task}
    return Table(
        caption=_caption(cells),
        corner=("task", "method"),
        rows=[
            _task_label(name, task)
            for name in ordered({environment for environment, _ in tasks}, order)
            for environment, task in sorted(tasks)
            if environment == name
        ],
        columns=ordered({cell.method for cell in cells}, order),
        estimates={
            (_task_label(environment, task), method): value
            for (environment, task, method), value in by_task.items()
        },
    )


def render(table: Table, style: str) -> str:
    """The table as text. Raises UserError when `style` is not one of `STYLES`."""
    return lookup("table format", STYLES, style)(table)


def markdown_grid(lines: Sequence[Sequence[str]]) -> str:
    """A Markdown table of `lines`, the header first: labels to the left, all else to the right."""
    header, *body = lines
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return "\n".join(
        "| " + " | ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])]) + " |"
        for line in [header, rule, *body]
    )


def ordered(names: Iterable[str], order: Sequence[str]) -> list[str]:
    """`names` without repetition: those in `order` first and as there, the others by alphabet."""
    rank = {name: number for number, name in enumerate(order)}
    return sorted(set(names), key=lambda name: (rank.get(name, len(rank)), name))


def _caption(cells: Mapping[Cell, Sequence[Result]]) -> str:
    profiles = sorted({result.run.config.physics for group in cells.values() for result in group})
    return (
        "Success rate in percent, mean ± standard deviation over seeds "
        f"(physics: {', '.join(profiles)})"
    )


def _task_label(environment: str, task: tuple[int, str]) -> str:
    return f"{environment} {task[1]}"


def _markdown(table: Table) -> str:
    header = [table.corner[0], *table.columns]
    body = _body(table, plus_minus=" ± ", nothing="–")
    return "\n".join([markdown_grid([header, *body]), "", table.caption, ""])


def _latex(table: Table) -> str:
    body = _body(table, plus_minus=r" $\pm$ ", nothing="--")
    lines = [
        [table.corner[0], *map(_escape, table.columns)],
        *([_escape(label), *values] for label, *values in body),
    ]
    header, *rows = (" & ".join(line) + r" \\" for line in lines)
    caption = _escape(table.caption).replace("±", r"$\pm$")
    return "\n".join(
        [
            r"\documentclass{article}",
            r"\usepackage{booktabs}",
            r"\begin{document}",
            r"\begin{table}",
            r"\centering",
            rf"\caption{{{caption}}}",
            rf"\begin{{tabular}}{{l{'r' * len(table.columns)}}}",
            r"\toprule",
            header,
            r"\midrule",
            *rows,
            r"\bottomrule",
            r"\end{tabular}",
            r"\end{table}",
            r"\end{document}",
            "",
        ]
    )


def _csv(table: Table) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*table.corner, *Estimate._fields])
    for row in table.rows:
        for column in table.columns:
            if (row, column) in table.estimates:
                writer.writerow([row, column, *table.estimates[row, column]])
    return text.getvalue()


STYLES: Mapping[str, Callable[[Table], str]] = {
    "markdown": _markdown,
    "latex": _latex,
    "csv": _csv,
}


def _body(table: Table, *, plus_minus: str, nothing: str) -> list[list[str]]:
    def text(value: Estimate | None) -> str:
        if value is None:
            return nothing
        if value.deviation is None:
            return f"{value.mean:.1f}"
        return f"{value.mean:.1f}{plus_minus}{value.deviation:.1f}"

    return [
        [row, *(text(table.estimates.get((row, column))) for column in table.columns)]
        for row in table.rows
    ]


def _escape(text: str) -> str:
    return re.sub(r"([#$%&_{}])", r"\\\1", text)
