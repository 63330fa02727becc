"""Tables of estimates as Markdown, LaTeX or CSV."""

import csv
import dataclasses
import io
from collections.abc import Callable, Collection, Mapping, Sequence

from pigbench.errors import lookup
from pigbench.report.stats import Estimate

Label = tuple[str, str]  # row and column

_LATEX_COLUMNS = 5  # that fit on a page
_LATEX_ESCAPES = str.maketrans(
    {
        **{character: rf"\{character}" for character in "#$%&_{}"},
        "\\": r"\textbackslash{}",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
        "<": r"\textless{}",
        ">": r"\textgreater{}",
        "±": r"$\pm$",
        "–": "--",
        "\n": " ",
    }
)


_MARKDOWN_ESCAPES = str.maketrans(
    {character: rf"\{character}" for character in "\\`*|<$["} | {"\n": " "}
)


@dataclasses.dataclass(frozen=True)
class Table:
    """Estimates by row and column label; `corner` names both kinds of label."""

    caption: str
    corner: Label
    rows: Sequence[str]
    columns: Sequence[str]
    estimates: Mapping[Label, Estimate]
    bold: Collection[Label] = frozenset()


def render(table: Table, style: str) -> str:
    """The table as text. Raises UserError if `style` is not one of `STYLES`."""
    return render_all([table], style)


def render_all(tables: Sequence[Table], style: str) -> str:
    """Like `render`, for several tables in one document."""
    return lookup("table format", STYLES, style)(tables)


def markdown_grid(lines: Sequence[Sequence[str]]) -> str:
    """A Markdown table of `lines`, header first; labels are aligned left, the rest right."""
    header, *body = lines
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return "\n".join(
        "| " + " | ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])]) + " |"
        for line in [header, rule, *body]
    )


def _markdown(tables: Sequence[Table]) -> str:
    return "\n".join(map(_markdown_table, tables))


def _markdown_table(table: Table) -> str:
    lines = _lines(table, table.columns, name=_escape_markdown, value=str, bold="**{}**")
    return f"{markdown_grid(lines)}\n\n{table.caption}\n"


def _escape_markdown(text: str) -> str:
    return text.translate(_MARKDOWN_ESCAPES)


def _latex(tables: Sequence[Table]) -> str:
    return "\n".join(
        [
            r"\documentclass{article}",
            r"\usepackage[margin=2cm]{geometry}",
            r"\usepackage{booktabs}",
            r"\usepackage{graphicx}",
            r"\begin{document}",
            *(line for table in tables for line in _latex_table(table)),
            r"\end{document}",
            "",
        ]
    )


def _latex_table(table: Table) -> list[str]:
    """The lines of a float: one grid for every `_LATEX_COLUMNS` columns, one below another."""
    starts = range(0, len(table.columns), _LATEX_COLUMNS)
    grids = [_latex_grid(table, table.columns[start : start + _LATEX_COLUMNS]) for start in starts]
    return [
        r"\begin{table}",
        r"\centering",
        rf"\caption{{{_escape(table.caption)}}}",
        *(line for grid in grids for line in grid),
        r"\end{table}",
    ]


def _latex_grid(table: Table, columns: Sequence[str]) -> list[str]:
    lines = _lines(table, columns, name=_escape, value=_escape, bold=r"\textbf{{{}}}")
    header, *body = (" & ".join(line) + r" \\" for line in lines)
    return [
        # Shrunk if it is wider than the page.
        r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%",
        rf"\begin{{tabular}}{{l{'r' * len(columns)}}}",
        r"\toprule",
        header,
        r"\midrule",
        *body,
        r"\bottomrule",
        r"\end{tabular}}",
        r"\par\medskip",
    ]


def _lines(
    table: Table,
    columns: Sequence[str],
    *,
    name: Callable[[str], str],
    value: Callable[[str], str],
    bold: str,
) -> list[list[str]]:
    """The header and rows as text, with names and values escaped; `bold` formats bold values."""

    def text(label: Label) -> str:
        shown = value(_text(table.estimates.get(label)))
        return bold.format(shown) if label in table.bold else shown

    header = [name(label) for label in (table.corner[0], *columns)]
    rows = [[name(row), *(text((row, column)) for column in columns)] for row in table.rows]
    return [header, *rows]


def _text(estimate: Estimate | None) -> str:
    if estimate is None:
        return "–"
    if estimate.deviation is not None:
        return f"{estimate.value:.1f} ± {estimate.deviation:.1f}"
    if estimate.interval is not None:
        return f"{estimate.value:.1f} [{estimate.interval.low:.1f}, {estimate.interval.high:.1f}]"
    return f"{estimate.value:.1f}"


def _escape(text: str) -> str:
    return text.translate(_LATEX_ESCAPES)


def _csv(tables: Sequence[Table]) -> str:
    return "\n".join(map(_csv_table, tables))


def _csv_table(table: Table) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*table.corner, "value", "deviation", "low", "high", "seeds", "bold"])
    for row in table.rows:
        for column in table.columns:
            if (row, column) in table.estimates:
                value, deviation, interval, seeds = table.estimates[row, column]
                bounds = interval or (None, None)
                bold = int((row, column) in table.bold)
                writer.writerow([row, column, value, deviation, *bounds, seeds, bold])
    return text.getvalue()


STYLES: Mapping[str, Callable[[Sequence[Table]], str]] = {
    "markdown": _markdown,
    "latex": _latex,
    "csv": _csv,
}
