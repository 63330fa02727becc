import csv
import io
import re
import shutil
import subprocess

import pytest

from pigbench.errors import UserError
from pigbench.report import stats, tables
from pigbench.report.tables import Table


@pytest.fixture
def results(tmp_path, make_run):
    double = {"environment": "cube-double"}
    return stats.read_results(
        [
            make_run(tmp_path / "a", {1: [[1, 1], [0, 1]]}),
            make_run(tmp_path / "b", {1: [[0, 0], [0, 1]]}, seed=1),
            make_run(tmp_path / "c", {1: [[1, 0], [1, 1]]}, **double),
            make_run(tmp_path / "d", {1: [[1, 1], [1, 1]]}, method="qrl", **double),
        ]
    )


ORDER = ("cube-single", "cube-double", "qrl", "gcivl")


def test_markdown_of_methods_by_environments(results):
    table = tables.method_table(results, order=ORDER)
    assert tables.render(table, "markdown") == (
        "| method | cube-single | cube-double |\n"
        "| ------ | ----------: | ----------: |\n"
        "| qrl    |           – |       100.0 |\n"
        "| gcivl  | 50.0 ± 35.4 |        75.0 |\n"
        "\n"
        "Success rate in percent, mean ± standard deviation over seeds (physics: exact)\n"
    )


def test_csv_of_tasks_by_methods(results):
    text = tables.render(tables.task_table(results, order=ORDER), "csv")
    assert list(csv.reader(io.StringIO(text))) == [
        ["task", "method", "mean", "deviation", "seeds"],
        ["cube-single task1", "gcivl", "50.0", "70.71067811865476", "2"],
        ["cube-single task2", "gcivl", "50.0", "0.0", "2"],
        ["cube-double task1", "qrl", "100.0", "", "1"],
        ["cube-double task1", "gcivl", "50.0", "", "1"],
        ["cube-double task2", "qrl", "100.0", "", "1"],
        ["cube-double task2", "gcivl", "100.0", "", "1"],
    ]


def test_latex_is_a_whole_document(tmp_path, results):
    text = tables.render(tables.method_table(results, order=ORDER), "latex")
    opened = re.findall(r"\\begin\{(\w+)\}", text)
    closed = re.findall(r"\\end\{(\w+)\}", text)
    assert opened == closed[::-1] == ["document", "table", "tabular"]
    assert text.count("{") == text.count("}")
    rows = re.search(r"\\midrule\n(.*)\\bottomrule", text, re.DOTALL)
    assert rows is not None
    assert rows[1] == ("qrl & -- & 100.0 \\\\\ngcivl & 50.0 $\\pm$ 35.4 & 75.0 \\\\\n")
    assert text.isascii()
    if shutil.which("pdflatex"):
        (tmp_path / "table.tex").write_text(text)
        command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "table.tex"]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)


def test_latex_escapes_names():
    estimates = {("a_b", "50%"): stats.estimate([1.0])}
    table = Table("R&D", ("method", "environment"), ["a_b"], ["50%"], estimates)
    text = tables.render(table, "latex")
    assert "a\\_b & 1.0" in text
    assert "method & 50\\% \\\\" in text
    assert "\\caption{R\\&D}" in text


def test_unknown_names_come_after_the_known_by_alphabet():
    assert tables.ordered(["z", "b", "a", "b"], ["b", "q"]) == ["b", "a", "z"]


def test_an_unknown_format_offers_the_nearest(results):
    table = tables.method_table(results)
    with pytest.raises(UserError, match="unknown table format 'latx': did you mean 'latex'"):
        tables.render(table, "latx")
