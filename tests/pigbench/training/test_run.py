import dataclasses
import json

import pytest

from pigbench.errors import UserError
from pigbench.training import run as runs


def test_a_run_is_begun_read_and_taken_up_again(tmp_path, config):
    path = tmp_path / "suite" / "run"
    begun = runs.open_run(path, config, {"commit": "abc"})
    assert runs.read_run(path) == begun
    assert runs.open_run(path, config, {"commit": "def"}) == begun
    assert json.loads((path / "provenance.json").read_text()) == {"commit": "abc"}
    assert begun.episodes_path == path / "episodes.csv"


def test_tuples_in_a_configuration_equal_what_was_read(tmp_path, config):
    config = dataclasses.replace(config, agent={"hidden": (256, 256)})
    runs.open_run(tmp_path, config, {})
    runs.open_run(tmp_path, config, {})


def test_another_configuration_is_refused_with_the_field(tmp_path, config):
    runs.open_run(tmp_path, config, {})
    changed = dataclasses.replace(config, agent=config.agent | {"discount": 0.9})
    with pytest.raises(UserError, match=r"agent\.discount is 0\.99 there and 0\.9 now"):
        runs.open_run(tmp_path, changed, {})


def test_what_is_no_run_is_named(tmp_path):
    with pytest.raises(UserError, match="missing does not exist"):
        runs.read_run(tmp_path / "missing")
    with pytest.raises(UserError, match=r"is no run: it has no config\.json"):
        runs.read_run(tmp_path)


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"method": "gcivl"}'])
def test_a_torn_configuration_is_named(tmp_path, text):
    (tmp_path / "config.json").write_text(text)
    with pytest.raises(UserError, match=r"config\.json is torn"):
        runs.read_run(tmp_path)
