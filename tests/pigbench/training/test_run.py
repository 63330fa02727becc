import dataclasses
import json

import numpy as np
import pytest

from pigbench import agents
from pigbench.agents import Statistics
from pigbench.errors import UserError
from pigbench.training import run as runs

STATISTICS = Statistics(np.array([0.1, -2.5], np.float32), np.array([1 / 3, 0.02], np.float32))


def test_a_run_is_begun_read_and_taken_up_again(tmp_path, config):
    path = tmp_path / "suite" / "run"
    begun = runs.open_run(path, config, {"commit": "abc"}, STATISTICS)
    assert runs.read_run(path) == begun
    assert runs.open_run(path, config, {"commit": "def"}, STATISTICS) == begun
    assert json.loads((path / "provenance.json").read_text()) == {"commit": "abc"}
    assert begun.episodes_path == path / "episodes.csv"


def test_what_a_run_goes_on_with_is_kept_where_it_is_something_else(tmp_path, config):
    def made(jax, commit="abc", command="train"):
        return {"versions": {"jax": jax, "mujoco": "3"}, "commit": commit, "command": command}

    def resume(step, origin):
        return runs.resume(runs.read_run(tmp_path), origin, step=step)

    def kept():
        return json.loads((tmp_path / "provenance.json").read_text())

    run = runs.open_run(tmp_path, config, made("1"), STATISTICS)
    assert resume(100, made("1", command="train again")) is None
    assert kept() == made("1")
    assert resume(100, made("2")) == "versions.jax was '1' and is '2'"
    assert resume(100, made("2")) is None
    assert resume(150, made("2", "def")) == "commit was 'abc' and is 'def'"
    assert kept() == made("1") | {"resumed": {"100": made("2"), "150": made("2", "def")}}
    runs.open_run(tmp_path, dataclasses.replace(config, steps=400), made("3"), STATISTICS)
    assert resume(200, made("3")) is None  # it was told as the run was extended
    assert resume(200, made("1")) == "versions.jax was '3' and is '1'"
    (run.path / "provenance.json").unlink()  # as of runs from before there was any
    assert resume(300, made("1")) == "versions.jax was 'absent' and is '1'"
    assert kept() == {"resumed": {"300": made("1")}}


def test_tuples_in_a_configuration_equal_what_was_read(tmp_path, config):
    config = dataclasses.replace(config, agent={"hidden": (256, 256)})
    runs.open_run(tmp_path, config, {}, STATISTICS)
    runs.open_run(tmp_path, config, {}, STATISTICS)


def test_another_configuration_is_refused_with_the_field(tmp_path, config):
    runs.open_run(tmp_path, config, {}, STATISTICS)
    changed = dataclasses.replace(config, agent=config.agent | {"discount": 0.9})
    with pytest.raises(UserError, match=r"agent\.discount is 0\.99 there and 0\.9 now"):
        runs.open_run(tmp_path, changed, {}, STATISTICS)


def test_what_is_no_run_is_named(tmp_path):
    with pytest.raises(UserError, match="missing does not exist"):
        runs.read_run(tmp_path / "missing")
    with pytest.raises(UserError, match=r"is not a run: it has no config\.json"):
        runs.read_run(tmp_path)


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"method": "gcivl"}'])
def test_a_torn_configuration_is_named(tmp_path, text):
    (tmp_path / "config.json").write_text(text)
    with pytest.raises(UserError, match=r"config\.json is torn"):
        runs.read_run(tmp_path)


@pytest.mark.parametrize("value", [-1, 1.5, True, [], ["state"], {"kind": "x"}])
def test_a_configuration_of_other_types_is_named(tmp_path, config, value):
    of_kind = {"agent": {"regularizer": {"kind": value}}}
    for changes in ({"agent": {"goals": value}}, {"evaluation": {"engine": value}}, of_kind):
        content = dataclasses.asdict(config) | {"method": "gcivl"} | changes
        (tmp_path / "config.json").write_text(json.dumps(content))
        with pytest.raises(UserError, match=r"config\.json (is torn: |holds no configuration)"):
            runs.agent_config(runs.read_run(tmp_path))


def test_statistics_are_kept_to_the_bit(tmp_path, config):
    run = runs.open_run(tmp_path, config, {}, STATISTICS)
    kept = runs.read_statistics(run)
    for ours, theirs in zip(kept, STATISTICS, strict=True):
        assert ours.dtype == np.float32
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("content", ['{"mean": [1.0]}', '{"mean": "x", "deviation": "y"}', "[]"])
def test_torn_statistics_are_named(tmp_path, config, content):
    run = runs.open_run(tmp_path, config, {}, STATISTICS)
    (tmp_path / runs.STATISTICS_FILE).write_text(content)
    with pytest.raises(UserError, match=r"statistics\.json is torn"):
        runs.read_statistics(run)


def test_a_run_of_before_statistics_has_none(tmp_path, config):
    run = runs.open_run(tmp_path, config, {}, STATISTICS)
    (tmp_path / runs.STATISTICS_FILE).unlink()
    assert runs.read_statistics(run) is None


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
    assert runs.agent_config(runs.read_run(new.path)) == kept
    assert runs.agent_config(runs.read_run(old.path)) == dataclasses.replace(
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
    assert runs.agent_config(runs.read_run(run.path)) == expected
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
        runs.agent_config(run)


def test_a_folder_of_something_else_is_left_alone(tmp_path, config, data):
    before = set(data.iterdir())
    with pytest.raises(UserError, match="holds no run; choose another"):
        runs.open_run(data, config, {}, STATISTICS)
    assert set(data.iterdir()) == before


def test_a_run_that_was_cut_off_as_it_began_begins(tmp_path, config):
    for name in ("provenance.json", ".statistics.json.tmp"):
        (tmp_path / name).write_text("")
    assert runs.open_run(tmp_path, config, {}, STATISTICS).config == config


def test_episodes_in_noise_are_found_among_other_files(tmp_path, config):
    run = runs.open_run(tmp_path, config, {}, STATISTICS)
    assert run.noise_paths() == {}
    folder = tmp_path / "noise"
    folder.mkdir()
    for name in ("20.csv", "2.5.csv", "0.csv", "5 (copy).csv", "20.0.csv", "nan.csv", "5.txt"):
        (folder / name).touch()
    expected = {level: folder / f"{level:g}.csv" for level in (0, 2.5, 20)}
    assert list(run.noise_paths().items()) == list(expected.items())


@pytest.mark.parametrize(
    ("saved", "step"),
    [
        (((), ()), None),
        (((0,), ()), None),  # killed in between
        (((0, 100), (0, 100, 200)), 100),
        (((100, 200), (), (0,)), "--seeds 1 2"),  # the first is trained already
        (((100, 150), (), (0, 50)), "--seeds 0 and --seeds 1 and --seeds 2"),
    ],
)
def test_runs_go_on_together_from_a_step_that_all_have(tmp_path, config, saved, step):
    together = []
    for seed, steps in enumerate(saved):
        run = runs.Run(tmp_path / str(seed), dataclasses.replace(config, seed=seed))
        run.checkpoints_path.mkdir(parents=True)
        for one in steps:
            (run.checkpoints_path / str(one)).mkdir()
        (run.checkpoints_path / "300.orbax-checkpoint-tmp").mkdir()
        assert run.is_trained == (200 in steps)
        together.append(run)
    if isinstance(step, str):
        with pytest.raises(UserError, match=f"to go on from together: ask for {step}$"):
            runs.common_step(together)
    else:
        assert runs.common_step(together) == step
