import csv
import io
import re
import shutil
import subprocess

import pytest

from pigbench.errors import UserError
from pigbench.report import formats
from pigbench.report.bootstrap import Interval
from pigbench.report.formats import Table
from pigbench.report.stats import Estimate

ESTIMATES = {
    ("a", "x"): Estimate(50.0, 35.36, Interval(25.0, 75.0), 2),
    ("b", "x"): Estimate(7.25),
    ("b", "y"): Estimate(12.0, None, Interval(0.0, 20.0), 3),
}
TABLE = Table("A caption ± 5 %", ("row", "column"), ["a", "b"], ["x", "y"], ESTIMATES, {("a", "x")})


def compile_latex(text, folder):
    if shutil.which("pdflatex"):
        (folder / "table.tex").write_text(text)
        command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "table.tex"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        log = (folder / "table.log").read_text(errors="replace")
        assert "Overfull" not in log


def test_markdown():
    assert formats.render(TABLE, "markdown") == (
        "| row |               x |                y |\n"
        "| --- | --------------: | ---------------: |\n"
        "| a   | **50.0 ± 35.4** |                – |\n"
        "| b   |             7.2 | 12.0 [0.0, 20.0] |\n"
        "\n"
        "A caption ± 5 %\n"
    )


def test_csv_has_every_number():
    assert list(csv.reader(io.StringIO(formats.render(TABLE, "csv")))) == [
        ["row", "column", "value", "deviation", "low", "high", "seeds", "bold"],
        ["a", "x", "50.0", "35.36", "25.0", "75.0", "2", "1"],
        ["b", "x", "7.25", "", "", "", "1", "0"],
        ["b", "y", "12.0", "", "0.0", "20.0", "3", "0"],
    ]


def test_latex_is_a_whole_document(tmp_path):
    text = formats.render(TABLE, "latex")
    opened = re.findall(r"\\begin\{(\w+)\}", text)
    closed = re.findall(r"\\end\{(\w+)\}", text)
    assert opened == closed[::-1] == ["document", "table", "tabular"]
    rows = re.search(r"\\midrule\n(.*)\\bottomrule", text, re.DOTALL)
    assert rows is not None
    assert rows[1] == (
        "a & \\textbf{50.0 $\\pm$ 35.4} & -- \\\\\nb & 7.2 & 12.0 [0.0, 20.0] \\\\\n"
    )
    assert text.isascii()
    compile_latex(text, tmp_path)


def test_wide_latex_tables_go_on_below_and_stay_on_the_page(tmp_path):
    columns = [f"pi-h-flow-hjb-gcivl-{number}" for number in range(18)]
    estimates = {
        ("cube-single task1_horizontal", column): ESTIMATES["a", "x"] for column in columns
    }
    wide = Table("Wide", ("task", "method"), ["cube-single task1_horizontal"], columns, estimates)
    text = formats.render_all([TABLE, wide], "latex")
    assert [text.count(rf"\begin{{{name}}}") for name in ("document", "table", "tabular")] == [
        1,
        2,
        1 + 4,
    ]
    compile_latex(text, tmp_path)


def test_latex_escapes_names(tmp_path):
    table = Table(
        "R&D ~ 5 % < 6^2", ("m", "e"), ["a_b\\c"], ["50%"], {("a_b\\c", "50%"): Estimate(1.0)}
    )
    text = formats.render(table, "latex")
    assert "a\\_b\\textbackslash{}c & 1.0" in text
    assert "m & 50\\% \\\\" in text
    assert "\\caption{R\\&D \\textasciitilde{} 5 \\% \\textless{} 6\\textasciicircum{}2}" in text
    compile_latex(text, tmp_path)


@pytest.mark.parametrize("style", formats.STYLES)
def test_several_tables_keep_their_order(style):
    text = formats.render_all([TABLE, Table("Other", ("corner", "q"), [], ["z"], {})], style)
    assert text.index("row") < text.index("12.0") < text.index("corner")


def test_an_unknown_format_offers_the_nearest():
    with pytest.raises(UserError, match="unknown table format 'latx': did you mean 'latex'"):
        formats.render(TABLE, "latx")
