"""Minari itself reads what is exported for it."""

import dataclasses
import json

import gymnasium
import numpy as np
import pytest

from pigbench import cli, envs
from pigbench.data import dataset
from pigbench.errors import UserError
from pigbench.support import files

pytest.importorskip("pyarrow")
minari = pytest.importorskip("minari")


@pytest.fixture
def exported(data, tmp_path, monkeypatch):
    cli.run(["data", "export", str(data), "--format", "minari", "--out", str(tmp_path / "out")])
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "out"))
    return dataset.load(data)


@pytest.mark.parametrize(("split", "name"), [("train", "play"), ("val", "play-val")])
def test_episodes_are_the_same_to_the_bit(exported, split, name):
    ours = exported.split(split)
    theirs = minari.load_dataset(f"pigbench/cube-single-{name}-v0")
    observations = ours.concatenate("observations").reshape(-1, 4, 9)
    actions = ours.concatenate("actions").reshape(-1, 4, 5)
    assert theirs.total_episodes == len(observations)
    assert theirs.total_steps == 3 * len(observations)
    for number, episode in enumerate(theirs.iterate_episodes()):
        assert episode.observations.dtype == np.float32
        np.testing.assert_array_equal(episode.observations, observations[number])
        np.testing.assert_array_equal(episode.actions, actions[number, :-1])
        np.testing.assert_array_equal(episode.truncations, [False, False, True])
        assert not episode.terminations.any()
        assert not episode.rewards.any()


def test_spaces_and_environment_are_told(exported):
    theirs = minari.load_dataset("pigbench/cube-single-play-v0")
    assert theirs.spec.env_spec.id == "pigbench/cube-single-v0"
    assert theirs.observation_space.shape == (9,)
    assert np.isinf(theirs.observation_space.high).all()
    assert (theirs.action_space.low == -1).all()
    assert theirs.storage.metadata["algorithm_name"] == "play"


def test_the_description_says_who_made_the_data(exported, imported, tmp_path):
    theirs = minari.load_dataset("pigbench/cube-single-play-v0")
    assert "made by pigbench with seed 3" in theirs.storage.metadata["description"]
    out = tmp_path / "out" / "more"
    cli.run(["data", "export", str(imported), "--format", "minari", "--out", str(out)])
    about = json.loads(next(out.rglob("data/metadata.json")).read_text())
    assert "imported by pigbench from arm.csv SHA-256 ab" in about["description"]
    assert "seed" not in about["description"]


def test_an_environment_of_ones_own_is_exported_and_one_that_is_unknown_is_said(
    data, tmp_path, monkeypatch
):
    path = data / "manifest.json"
    content = files.read_sealed(path)
    content["spec"]["environment"] = "cube-mine"
    files.write_sealed(path, content)
    export = ["data", "export", str(data), "--format", "minari", "--out", str(tmp_path / "out")]
    with pytest.raises(UserError, match="unknown environment 'cube-mine'"):
        cli.run(export)
    assert not (tmp_path / "out").exists()
    own = dataclasses.replace(envs.SPECS["cube-single"], name="cube-mine")
    monkeypatch.setitem(envs.SPECS, own.name, own)
    cli.run(export)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "out"))
    theirs = minari.load_dataset("pigbench/cube-mine-play-v0")
    assert theirs.spec.env_spec.id == "pigbench/cube-mine-v0"
    del gymnasium.registry[theirs.spec.env_spec.id]
    assert theirs.spec.env_spec.max_episode_steps == own.episode_length


def test_what_lies_there_is_left_alone_and_other_formats_choices_are_refused(data, tmp_path):
    export = ["data", "export", str(data), "--format", "minari", "--out"]
    with pytest.raises(UserError, match="is not an empty folder"):
        cli.run([*export, str(data)])
    with pytest.raises(UserError, match="goals is 'cubes': format 'minari' has no such option"):
        cli.run([*export, str(tmp_path / "new"), "--goals", "cubes"])
    assert not (tmp_path / "new").exists()
