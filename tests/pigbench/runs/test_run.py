import dataclasses
import json

import pytest

from pigbench.agents import Statistics
from pigbench.errors import UserError
from pigbench.runs import run as runs
from pigbench.support import files

STATISTICS = Statistics.standard(1)


def test_a_run_is_begun_read_and_taken_up_again(tmp_path, config):
    path = tmp_path / "suite" / "run"
    begun = runs.open_run(path, config, {"commit": "abc"}, STATISTICS)
    assert runs.read_run(path) == begun
    assert runs.open_run(path, config, {"commit": "def"}, STATISTICS) == begun
    assert json.loads((path / "provenance.json").read_text()) == {"commit": "abc"}
    assert begun.episodes_path == path / "episodes.csv"


def test_tuples_in_a_configuration_equal_what_was_read(tmp_path, config):
    config = dataclasses.replace(config, agent=config.agent | {"hidden": (256, 256)})
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


@pytest.mark.parametrize(
    "changes",
    [{"seed": "a"}, {"agent": {}}, {"agent": {"goals": 1}}, {"evaluation": {"engine": None}}],
)
def test_an_invalid_configuration_is_named(tmp_path, config, changes):
    files.write_sealed(tmp_path / "config.json", dataclasses.asdict(config) | changes)
    with pytest.raises(UserError, match=rf"config\.json is invalid: {min(changes)}"):
        runs.read_run(tmp_path)


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
