"""Which episodes are good, by hand-made ones, and the data set of them."""

import json
from pathlib import Path

import numpy as np
import pytest

from pigbench import cli
from pigbench.data import dataset, manifest, quality, selection
from pigbench.data.manifest import Spec
from pigbench.data.quality import CRITERIA, JudgedColumns, Limits
from pigbench.data.writer import Writer
from pigbench.envs.terms import layout
from pigbench.errors import UserError
from pigbench.layout import Layout

GOAL = np.array([0.425, 0.0, 0.02])
LAYOUT = layout(1, {"effector_pos"})
LIMITS = Limits(min_rows=3, max_rows=50)


def off(*metres: float) -> np.ndarray:
    """A place so far from the goal."""
    return GOAL + np.array(metres)


AWAY, HIGH = off(0.1, 0.2, 0.0), off(0.05, 0.1, 0.2)


def episode(cube, contact=None, joint_vel=None) -> JudgedColumns:
    cube = np.array(cube)
    contact = np.zeros(len(cube)) if contact is None else np.array(contact)
    joint_vel = np.zeros((len(cube), 6)) if joint_vel is None else joint_vel
    return JudgedColumns(joint_vel, contact, cube, GOAL)


def fails(one: JudgedColumns) -> list[str]:
    measures = quality.measure(one, LIMITS)
    return [name for name in CRITERIA if not CRITERIA[name].good(measures[name], LIMITS)]


CARRIED = [0, 1, 1, 0]  # contact


@pytest.mark.parametrize(
    ("cube", "contact", "good"),
    [
        ([AWAY, HIGH, GOAL, GOAL], CARRIED, True),
        ([GOAL, HIGH, AWAY, AWAY], CARRIED, True),
        ([AWAY, HIGH, GOAL, AWAY], [0, 1, 0, 0], True),  # there and away again
        ([AWAY, HIGH, GOAL, GOAL], [0, 1, 1, 1], False),  # never let go
        ([AWAY, HIGH, AWAY, AWAY], CARRIED, False),
        ([GOAL, GOAL, GOAL, GOAL], CARRIED, False),  # it was there
        ([AWAY, off(0, 0, 0.1), AWAY, AWAY], [0, 0, 0, 0], False),  # over it
        ([AWAY, HIGH, off(0.03, 0.03, 0), off(0.03, 0.03, 0)], CARRIED, True),
        ([AWAY, HIGH, off(0.04, 0.04, 0), off(0.04, 0.04, 0)], CARRIED, False),
    ],
)
def test_success_is_a_cube_that_lay_at_the_goal_and_elsewhere(cube, contact, good):
    assert ("success" not in fails(episode(cube, contact))) == good


def test_a_drop_is_a_cube_that_is_lost_in_the_air():
    assert "drops" in fails(episode([AWAY, HIGH, HIGH, AWAY], [0, 1, 0, 0]))
    assert "drops" not in fails(episode([AWAY, HIGH, AWAY, AWAY], [0, 1, 1, 0]))
    assert quality.drops(episode([HIGH] * 6, [1, 0, 1, 0, 1, 1]), LIMITS) == 2


def test_jerk_is_the_second_difference_of_velocities():
    time = 0.05 * np.arange(20)
    cubic = np.zeros((20, 6))
    cubic[:, 0] = 3 * 40.0 * time**2 / 2  # of an angle 20 t^3, whose third derivative is 120
    assert quality.jerk(episode([AWAY] * 20, joint_vel=cubic), LIMITS) == pytest.approx(
        120 / np.sqrt(6)
    )
    assert quality.jerk(episode([AWAY] * 2), LIMITS) == 0


@pytest.mark.parametrize(("rows", "good"), [(2, False), (3, True), (50, True), (51, False)])
def test_length_is_within_its_limits(rows, good):
    assert ("length" not in fails(episode([AWAY] * rows))) == good


def make(folder: Path, lengths: list[list[int]], environment: str = "cube-centre") -> Path:
    """A data set whose episodes' joints stand at their number; those of 7 rows reach the goal."""
    spec = Spec(
        environment=environment,
        policy="replan",
        physics="exact",
        engine="mujoco",
        seed=0,
        episodes={"train": sum(map(len, lengths)), "val": 0},
        episodes_per_shard={"train": tuple(map(len, lengths)), "val": ()},
        rows_per_episode=0,
        fields=("observations", "actions", "terminals"),
        layout=LAYOUT,
        action_size=5,
        versions={},
    )
    writer, number = Writer(folder, spec), 0
    for part, own in zip(spec.plan(), lengths, strict=True):
        rows = np.zeros((sum(own), LAYOUT.size), np.float32)
        ends = np.cumsum(own)
        for start, stop in zip(ends - own, ends, strict=True):
            rows[start:stop, LAYOUT["joint_pos"]] = number
            cube = np.tile(AWAY, (stop - start, 1))
            cube[-1] = GOAL if stop - start == 7 else AWAY
            rows[start:stop, LAYOUT["cube_0_pos"]] = 10 * (cube - [0.425, 0, 0])
            number += 1
        terminals = np.isin(np.arange(sum(own)), ends - 1)
        actions = np.zeros((sum(own), 5), np.float32)
        writer.write(part, {"observations": rows, "actions": actions, "terminals": terminals})
    return folder


def test_good_episodes_are_kept_as_they_are(tmp_path, capsys):
    source = make(tmp_path / "raw", [[7, 5, 7], [5, 5], [9, 7]])
    out = tmp_path / "good"
    command = ["data", "filter", str(source), "--out", str(out), "--criteria", "success", "length"]
    cli.run([*command, "--min-rows", "6"])
    assert not dataset.verify(out)
    split = dataset.load(out).split("train")
    joints = split.concatenate("observations")[:, 0]
    np.testing.assert_array_equal(joints, np.repeat([0, 2, 6], 7))
    np.testing.assert_array_equal(split.episode_ends, [6, 13, 20])
    printed = capsys.readouterr().out
    assert "kept: 3 of 7 episodes, 21 of 45 rows (47 %)" in printed
    assert "| success   | brought to within 0.05 m of the goal, or away |" in printed
    report = json.loads((out / selection.REPORT).read_text())
    assert [one["fails"] for one in report["dropped"]] == [
        *[["success", "length"]] * 3,
        ["success"],
    ]
    assert report["dropped"][0]["first row"] == 7
    assert report["of"] == dataset.load(source).digest
    # Once more, it does nothing; with other limits it is another data set.
    before = manifest.read(out)
    cli.run([*command, "--min-rows", "6"])
    assert manifest.read(out) == before
    with pytest.raises(UserError, match="filtered by"):
        cli.run([*command, "--min-rows", "7"])


@pytest.mark.parametrize(
    ("options", "environment", "complaint"),
    [
        (["--criteria", "sucess"], "cube-centre", "did you mean 'success'"),
        (["--min-rows", "60"], "cube-centre", "no training episode of .* passes success, jerk"),
        (["--min-rows", "271"], "cube-centre", "min_rows is 271: it must be at most max_rows,"),
        (
            ["--criteria", "success", "--max-jerk", "7"],
            "cube-centre",
            "max_jerk has no effect without criterion 'jerk': leave it out",
        ),
        ([], "cube-single", "judged by the only goal of one cube"),
    ],
)
def test_what_cannot_be_filtered_is_refused(tmp_path, options, environment, complaint):
    source = make(tmp_path / "raw", [[7]], environment)
    with pytest.raises(UserError, match=complaint):
        cli.run(["data", "filter", str(source), "--out", str(tmp_path / "good"), *options])
    assert not (tmp_path / "good").exists()


def test_observations_must_tell_what_is_judged():
    with pytest.raises(UserError, match="tell no gripper_contact, cube_0_pos"):
        quality.episode(np.zeros((3, 6)), Layout.of({"joint_vel": 6}), GOAL)
