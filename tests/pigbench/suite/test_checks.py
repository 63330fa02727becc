"""What a suite finds when it begins, and whether it is what the suite asks for."""

import dataclasses
from typing import Any

import pytest

from pigbench import cli
from pigbench.agents import Statistics
from pigbench.data import manifest
from pigbench.data.collect import COMPACT, FIELDS
from pigbench.data.manifest import Manifest, Spec
from pigbench.errors import UserError
from pigbench.runs import run as runs
from pigbench.suite import spec as suites
from pigbench.suite.checks import Trainings, checked_trainings

TEXT = """
preset = "cpu"
methods = ["gcivl"]
seeds = [0]
evaluation = {every = 5, episodes = 1}

[[environments]]
name = "cube-single"
transitions = 3_000
steps = 10
"""
FILTERED = {"filtered by": "jerk"}
CELL = "cube-single/gcivl/0"


@pytest.fixture
def check(write, tmp_path):
    """`check(text)`: what is checked of a suite file with that text, in the folder `out`."""

    def check(text: str) -> Trainings:
        return checked_trainings(suites.read(write(text)), tmp_path / "out", cli.parse)

    return check


@pytest.fixture
def put(spec, tmp_path):
    """`put(folder, **changes)`: a data set there, as the suite's own command begins it."""
    as_asked = dataclasses.replace(
        spec, seed=0, episodes={"train": 3, "val": 1}, rows_per_episode=1001, fields=FIELDS
    )

    def put(folder: str, **changes: Any) -> Spec:
        (tmp_path / folder).mkdir(parents=True)
        content = dataclasses.replace(as_asked, **changes)
        manifest.write(tmp_path / folder, Manifest(content, ()))
        return content

    return put


@pytest.mark.parametrize(
    ("asked", "changes"),
    [
        ("", {}),
        ("compact = true", {"fields": COMPACT}),
        ("policy = 'noisy'\nseed = 7", {"policy": "noisy", "seed": 7}),
        ("validation_episodes = 0", {"episodes": {"train": 3, "val": 0}}),
        (
            "episode_transitions = 1500",
            {"episodes": {"train": 2, "val": 1}, "rows_per_episode": 1501},
        ),
        ("filter = true", {"episodes": {"train": 2, "val": 1}, "origin": FILTERED}),
    ],
)
def test_own_data_that_are_as_asked_are_used(check, put, asked, changes):
    put("out/data/cube-single", **changes)
    check(f"{TEXT}[data]\n{asked}")


@pytest.mark.parametrize(
    ("asked", "changes", "complaint"),
    [
        ("policy = 'noisy'", {}, "policy is 'play' there and 'noisy' now"),
        ("", {"policy": "noisy"}, "policy is 'noisy' there and 'play' now"),
        ("seed = 7", {}, "seed is 0 there and 7 now"),
        ("compact = true", {}, "compact is False there and True now"),
        ("filter = true", {}, "filter is False there and True now"),
        ("", {"origin": FILTERED}, "filter is True there and False now"),
        ("", {"episodes": {"train": 4, "val": 1}}, "episodes.train is 4 there and 3 now"),
        ("validation_episodes = 2", {}, "episodes.val is 1 there and 2 now"),
        ("episode_transitions = 1100", {}, "rows_per_episode is 1001 there and 1101 now"),
    ],
)
def test_own_data_that_are_not_as_asked_are_refused(check, put, asked, changes, complaint):
    put("out/data/cube-single", **changes)
    with pytest.raises(UserError, match=f"cube-single was made with another .*{complaint}"):
        check(f"{TEXT}[data]\n{asked}")


def test_data_that_will_be_filtered_are_compared_too(check, put):
    put("out/data/cube-single", origin=FILTERED)
    put("out/data/cube-single-raw", episodes={"train": 4, "val": 1})
    with pytest.raises(UserError, match=r"cube-single-raw was made .*train is 4 there and 3 now"):
        check(f"{TEXT}[data]\nfilter = true")


IMPORTED = {
    "policy": "robot",
    "seed": 1,
    "fields": COMPACT,
    "episodes": {"train": 77, "val": 9},
    "rows_per_episode": 0,
    "origin": FILTERED,
}


@pytest.mark.parametrize("asked", ["", "filter = true\ncompact = true", "validation_episodes = 2"])
def test_named_data_may_be_of_any_size_and_origin(check, put, tmp_path, asked):
    put("named", **IMPORTED)
    check(f'{TEXT}data = "{tmp_path / "named"}"\n[data]\n{asked}')


@pytest.mark.parametrize(
    ("asked", "complaint"),
    [
        ("policy = 'play'", "policy is 'robot' there and 'play' now"),
        ("seed = 0", "seed is 1 there and 0 now"),
        ("compact = false", "compact is True there and False now"),
        ("filter = false", "filter is True there and False now"),
    ],
)
def test_named_data_must_not_contradict_the_file(check, put, tmp_path, asked, complaint):
    """Even where what the file says is what it need not say."""
    put("named", **IMPORTED)
    with pytest.raises(UserError, match=f"named was made with another .*{complaint}"):
        check(f'{TEXT}data = "{tmp_path / "named"}"\n[data]\n{asked}')


@pytest.fixture
def trained(check, tmp_path):
    """`trained(text, **changes)`: the first cell's run as that suite leaves it, without data."""

    def trained(text: str, **changes: Any) -> None:
        (cell, training), *_ = check(text).items()
        config = dataclasses.replace(training, engine="another").config(
            0, environment="cube-single", physics="exact", dataset_digest="ab" * 32
        )
        config = dataclasses.replace(config, **changes)
        runs.open_run(tmp_path / "out" / cell.name, config, {}, Statistics.standard(1))

    return trained


SHARP = f"{TEXT}[variants.sharp]\nexpectile = 0.9\n"


@pytest.mark.parametrize(
    "text",
    [
        SHARP,  # on whatever machine it was trained
        SHARP.replace("steps = 10", "steps = 20"),
        SHARP.replace("episodes = 1}", "episodes = 1, noise = [5]}"),
        SHARP.replace("seeds = [0]", "seeds = [0, 1]"),
        SHARP.replace('["gcivl"]', '["hjb-gcivl", "gcivl"]'),
        f"keep = 'all'\nfilms = true{SHARP}",
        f"{SHARP}[variants.dull]\nexpectile = 0.6\n",
        TEXT,  # without the variant
    ],
)
def test_a_suite_may_grow_and_show_more(check, trained, text):
    trained(SHARP)
    check(text)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("0.9", "0.5", r"agent\.expectile is 0\.9 there and 0\.5 now; use 0\.9"),
        ("steps = 10", "steps = 5", "steps is 10 there and 5 now"),
        ("every = 5", "every = 2", r"evaluation\.every is 5 there and 2 now"),
        ("episodes = 1", "episodes = 2", r"evaluation\.episodes is 1 there and 2 now"),
        ('"cpu"', '"paper"', "preset is 'cpu' there and 'paper' now"),
    ],
)
def test_a_run_that_the_suite_would_train_otherwise_is_refused(check, trained, old, new, complaint):
    """Whatever suites were there in between: no file but the run's own is compared."""
    trained(SHARP)
    assert old in SHARP
    with pytest.raises(UserError, match=rf"gcivl\+sharp/0 was made .*{complaint}") as error:
        check(SHARP.replace(old, new))
    assert str(error.value).endswith("or choose another --out or name of a variant")
    assert "\n" not in str(error.value)


def test_a_run_of_other_defaults_is_refused(check, trained):
    """As those of an earlier version's preset may be."""
    (training,) = check(TEXT).values()
    trained(TEXT, agent=dataclasses.asdict(training.agent) | {"batch_size": 7})
    with pytest.raises(UserError, match=rf"{CELL} was made .*agent\.batch_size is 7 there and \d+"):
        check(TEXT)


def test_a_run_on_other_data_is_refused(check, trained, data):
    trained(TEXT)
    with pytest.raises(UserError, match=f"{CELL} was made .*dataset_digest is '(ab)+' there"):
        check(f'{TEXT}data = "{data}"\n')


def test_a_torn_run_is_left_to_its_cell(check, trained, tmp_path):
    trained(TEXT)
    (tmp_path / "out" / CELL / "config.json").write_text("{}")
    check(TEXT)
