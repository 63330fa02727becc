import dataclasses
import json
import shlex

from pigbench import cli
from pigbench.page import records
from pigbench.runs.run import read_run
from pigbench.suite import jobs, spec
from pigbench.suite.logs import log_path


def tell(folder, provenance):
    (folder / "provenance.json").write_text(json.dumps(provenance))


def test_what_differs_between_cells_comes_apart_from_what_they_share(tmp_path, make_run):
    agents = {
        "gcivl": {"discount": 0.99, "hidden": [8]},
        "hjb-gcivl": {"discount": 0.9, "hidden": [8], "speed": 1.0},
        "qrl": {"discount": 0.99, "hidden": [8], "speed": 1.0},
    }
    runs = [
        make_run(tmp_path / method / str(seed), {0: [[1]]}, method=method, seed=seed, agent=agent)
        for method, agent in agents.items()
        for seed in (1, 0)
    ]
    configs = records.configurations(runs, ("qrl", "gcivl"))
    told = records.compared(configs)
    assert list(configs) == ["cube-single qrl", "cube-single gcivl", "cube-single hjb-gcivl"]
    assert told.columns[0] == ["cube-single", "qrl"]
    assert told.differing == {
        "method": ["qrl", "gcivl", "hjb-gcivl"],
        "agent.discount": [0.99, 0.99, 0.9],
    }
    assert told.partial == {"agent.speed": [1.0, None, 1.0]}
    assert told.shared["seeds"] == [[0, 1]]
    assert told.shared["agent.hidden"] == [[8]]


def test_runs_of_one_provenance_share_a_column(runs):
    for number, folder in enumerate(runs):
        commit = "a" if number < 3 else "b"
        tell(folder, {"commit": commit, "versions": {"jax": "1"}, "command": f"train {number}"})
    told = records.provenance([read_run(folder) for folder in runs])
    assert list(told.columns) == [
        ["cube-single gcivl 0", "cube-single gcivl 1", "cube-single hjb-gcivl 0"],
        ["cube-double hjb-gcivl 0"],
    ]
    assert (told.shared, told.differing) == ({"versions.jax": ["1"]}, {"commit": ["a", "b"]})


def test_commands_are_those_that_were_typed(runs, monkeypatch):
    monkeypatch.setattr("sys.argv", ["/bin/pigbench", "report", "a run"])
    longer = {"200": {"command": "pigbench train gcivl --steps 200"}}
    for folder in runs[:2]:  # two seeds of one command
        tell(folder, {"command": "pigbench train gcivl --seeds 0 1", "extended": longer})
    page, made, old = records.commands(runs[:3])
    assert page.lines == ["pigbench report 'a run'"]
    assert made.lines == ["pigbench train gcivl --seeds 0 1", "pigbench train gcivl --steps 200"]
    assert old.lines == [str(runs[2])]


def test_commands_of_a_suite_make_its_cells(suite):
    _, made = records.commands([suite])
    commands = [cli.parse(shlex.split(line)[1:]) for line in made.lines]
    assert len(commands) == 1 + 4
    assert commands[0].out == suite / "data/cube-single"
    assert {command.out for command in commands[1:]} == {
        suite / "cube-single" / method / seed for method in ("gcivl", "hjb-gcivl") for seed in "01"
    }


def test_data_that_a_suite_found_are_not_said_to_be_generated(suite):
    kept = spec.read_kept(suite / spec.KEPT)
    (environment,) = kept.environments
    named = dataclasses.replace(environment, data=suite / "elsewhere")
    spec.write(suite / spec.KEPT, dataclasses.replace(kept, environments=(named,)))
    _, made = records.commands([suite])
    assert {line.split()[1] for line in made.lines} == {"train"}
    log_path(suite, jobs.data_job(named)).parent.mkdir(parents=True)
    log_path(suite, jobs.data_job(named)).touch()  # as the job that makes them does
    _, made = records.commands([suite])
    assert made.lines[0].startswith("pigbench generate cube-single --out")
