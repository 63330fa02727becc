import dataclasses
import json

import pytest

from pigbench import agents
from pigbench.agents import Statistics
from pigbench.errors import UserError
from pigbench.runs import run as runs
from pigbench.runs.restore import agent_config

STATISTICS = Statistics.standard(1)


@pytest.mark.parametrize("value", [-1, 1.5, True, [], ["state"], {"kind": "x"}])
def test_a_configuration_of_other_types_is_named(tmp_path, config, value):
    of_kind = {"agent": {"regularizer": {"kind": value}}}
    for changes in ({"agent": {"goals": value}}, {"evaluation": {"engine": value}}, of_kind):
        content = dataclasses.asdict(config) | {"method": "gcivl"} | changes
        (tmp_path / "config.json").write_text(json.dumps(content))
        with pytest.raises(UserError, match=r"config\.json (is invalid: |holds no configuration)"):
            agent_config(runs.read_run(tmp_path))


def test_fields_that_an_old_run_lacks_are_what_they_were_whatever_they_are_by_default(
    tmp_path, config, monkeypatch
):
    method = agents.get("pi-h-flow-hjb-gcivl")
    kept = dataclasses.replace(method.config, goals="cubes", standardize=True)
    fields = dataclasses.asdict(kept)
    now = dataclasses.replace(config, method=method.name, agent=fields)
    before = dataclasses.replace(
        now, agent={name: fields[name] for name in fields.keys() - {"goals", "standardize"}}
    )
    monkeypatch.setattr(agents, "get", lambda name: dataclasses.replace(method, config=kept))
    new = runs.open_run(tmp_path / "new", now, {}, STATISTICS)
    old = runs.open_run(tmp_path / "old", before, {}, STATISTICS)
    assert (new.config.goals, old.config.goals) == ("cubes", "state")
    assert agent_config(runs.read_run(new.path)) == kept
    assert agent_config(runs.read_run(old.path)) == dataclasses.replace(
        kept, goals="state", standardize=False
    )


OLD = {"kind": "hjb", "weight": 0.5, "speed": 1.0, "epsilon": 1e-6, "direction": "raw"}
"""A regulariser as stored when all kinds had the same fields."""


@pytest.fixture
def old_run(tmp_path, config):
    """`old_run(**fields)`: a run of GCIVL with the regulariser `OLD` but for these fields."""

    def old_run(**fields):
        agent = dataclasses.asdict(agents.get("gcivl").config)
        stored = dataclasses.replace(
            config, method="gcivl", agent=agent | {"regularizer": OLD | fields}
        )
        return runs.open_run(tmp_path, stored, {}, STATISTICS)

    return old_run


def test_a_run_of_before_kinds_had_their_own_fields_is_read_and_taken_up_again(old_run):
    """The kind need not be the method's own."""
    run = old_run()
    expected = agents.GCIVLConfig(regularizer=agents.HJBRegularizer(weight=0.5, direction="raw"))
    assert agent_config(runs.read_run(run.path)) == expected
    now = dataclasses.replace(run.config, agent=dataclasses.asdict(expected))
    resumed = runs.open_run(run.path, now, {}, STATISTICS).config
    assert resumed.agent["regularizer"] == now.agent["regularizer"]


@pytest.mark.parametrize(
    ("field", "value", "says"),
    [("speed", 2.0, "speed"), ("direction", "rwa", "did you mean 'raw'"), ("kind", "hbj", "hbj")],
)
def test_a_field_that_its_kind_lacks_is_refused(old_run, field, value, says):
    run = runs.read_run(old_run(**{field: value}).path)
    with pytest.raises(UserError, match=says):
        agent_config(run)
