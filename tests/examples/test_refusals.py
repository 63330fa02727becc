"""What examples say to bad input: one line, as commands do, before anything is written."""

import pytest

from pigbench.support import files

OUT = "OUT"
"""Stands for a folder of the test."""

INVALID = "INVALID"
"""Stands for the folder of a run whose configuration is invalid."""

REFUSED = [
    ("brax_ppo", "--environment cube-singel", "unknown environment 'cube-singel': did you mean"),
    ("brax_ppo", "--simulations 0", "simulations is 0: it must be at least 1"),
    ("brax_ppo", "--simulations 100", "simulations is 100: it must be a divisor of 512"),
    ("brax_ppo", "--seed -1", "seed is -1: it must be from 0 to 4294967295"),
    ("compare_methods", "--methods gcbc gcivel", "unknown method 'gcivel': did you mean"),
    ("compare_methods", "--methods", "--methods needs at least one value"),
    ("compare_methods", "--plugin none.py", "plugin none.py does not exist"),
    ("compare_methods", "--data /dev/null", "/dev/null is not a folder"),
    ("compare_methods", "--episodes -3", "episodes is -3: it must be at least 1"),
    ("compare_methods", "--steps 0", "steps is 0: it must be at least 1"),
    ("compare_methods", "--evaluation-episodes 0", "episodes is 0: it must be at least 1"),
    ("compare_methods", "--seeds 0 -1", "seed is -1: it must be from 0"),
    ("gymnasium_control", "--episodes 0", "episodes is 0: it must be at least 1"),
    ("gymnasium_control", "--every 0", "every is 0: it must be at least 1"),
    ("gymnasium_control", "--task 6", "task is 6: it must be from 1 to 5"),
    ("own_log", "--method hjb", "unknown method 'hjb': did you mean"),
    ("own_log", "--steps nan", "invalid"),
    ("own_log", "--logs none", "none does not exist"),
    ("value_map", "", "no runs are given"),
    ("value_map", "none", "none does not exist; make a run with `pigbench train`"),
    ("value_map", INVALID, "is invalid: method: this field is missing"),
    ("value_map", "none --points 1", "points is 1: it must be at least 2"),
]


@pytest.mark.parametrize(("name", "arguments", "complaint"), REFUSED)
def test_bad_input_is_refused_in_a_line(name, arguments, complaint, run, tmp_path, capsys):
    (tmp_path / "run").mkdir()
    files.write_sealed(tmp_path / "run" / "config.json", {"seed": 0})
    before = sorted(tmp_path.rglob("*"))
    given = [str(tmp_path / "run") if word == INVALID else word for word in arguments.split()]
    out = tmp_path / ("values.png" if name == "value_map" else "out")
    with pytest.raises(SystemExit) as ended:
        run(name, *given, "--out", out)
    assert ended.value.code == 2
    *_, line = capsys.readouterr().err.splitlines()  # after those of progress, if any
    assert line.startswith(f"{name}.py: ")
    assert complaint in line
    assert sorted(tmp_path.rglob("*")) == before


def test_every_script_reports_as_commands_do(examples):
    scripts = [path for path in examples.glob("*.py") if "__main__" in path.read_text()]
    assert {path.stem for path in scripts} == {name for name, _, _ in REFUSED}
    for path in scripts:
        assert path.read_text().endswith("    cli.script(Example)\n"), path
