"""Resampling, frames and what is made up, against formulas; and twenty bad logs."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.data.logs import tables
from pigbench.data.logs.episode import prepare
from pigbench.envs import servo
from pigbench.errors import UserError

PINCH = jax.jit(servo.pinch)
RATE = [f"action_{place}" for place in range(5)]


def commanded(columns) -> dict[str, np.ndarray]:
    """With poses commanded that lie a centimetre above where the gripper is, in the base frame."""
    joints = np.stack([columns[f"joint_pos_{place}"] for place in range(6)], axis=-1)
    still = np.ones(len(joints))
    x, y, z = np.asarray(PINCH(np.float32(joints[len(joints) // 2]))[0])
    target = {"x": -y * still, "y": x * still, "z": (z + 0.01) * still, "yaw": 0.2 * still}
    kept = {name: values for name, values in columns.items() if name not in RATE}
    return (
        kept
        | {f"target_{name}": value for name, value in target.items()}
        | {"target_opening": (np.arange(len(joints)) > len(joints) / 2).astype(float)}
    )


@pytest.mark.parametrize("hz", [20, 50, 125, 500])
def test_a_log_is_resampled_to_control_steps(table, hz):
    episode = prepare("log", commanded(table(hz)))
    assert episode.joint_pos.shape == (41, 6)
    time = 0.05 * np.arange(41)
    np.testing.assert_allclose(episode.joint_pos[:, 0], -1.3 + 0.2 * np.sin(2 * time), atol=1e-3)
    np.testing.assert_allclose(episode.joint_vel[:, 0], 0.4 * np.cos(2 * time), atol=2e-3)
    shut = episode.actions[:, 4] > 0
    assert not shut[time < 0.95].any()
    assert shut[time > 1.05].all()


def test_velocities_and_contact_are_made_up_where_there_are_none(table):
    columns = {name: x for name, x in commanded(table()).items() if "joint_vel" not in name}
    episode = prepare("log", columns)
    time = 0.05 * np.arange(41)
    np.testing.assert_allclose(episode.joint_vel[1:-1, 0], 0.4 * np.cos(2 * time[1:-1]), atol=2e-3)
    # The fingers stop at 0.6, after 1.3 s: something is between them.
    np.testing.assert_array_equal(episode.contact[time > 1.35], 1)
    np.testing.assert_array_equal(episode.contact[time < 1.25], 0)


def test_turns_of_joints_and_signs_of_quaternions_do_not_matter(table):
    expected = prepare("log", commanded(table()))
    columns = commanded(table())
    columns["joint_pos_0"] = columns["joint_pos_0"] + 2 * np.pi
    for name in ("object_qw", "object_qz"):
        columns[name] = columns[name] * np.where(np.arange(len(columns[name])) % 3, 1, -1)
    turned = prepare("log", columns)
    np.testing.assert_allclose(turned.joint_pos, expected.joint_pos, atol=1e-9)
    np.testing.assert_allclose(np.abs(turned.object_quat), np.abs(expected.object_quat), atol=1e-6)


def test_the_base_frame_is_that_of_the_manufacturers_kinematics():
    """Denavit and Hartenberg's parameters of the UR5e, as Universal Robots publishes them."""
    a = [0, -0.425, -0.3922, 0, 0, 0]
    d = [0.1625, 0, 0, 0.1333, 0.0997, 0.0996]
    alpha = np.pi / 2 * np.array([1, 0, 0, 1, -1, 0])
    for joints in np.random.default_rng(0).uniform(-3, 3, (5, 6)):
        frame = np.eye(4)
        for turn, twist, out, along in zip(joints, alpha, a, d, strict=True):
            c, s, ca, sa = np.cos(turn), np.sin(turn), np.cos(twist), np.sin(twist)
            link = [[c, -s * ca, s * sa, out * c], [s, c * ca, -c * sa, out * s]]
            frame = frame @ np.array([*link, [0, sa, ca, along], [0, 0, 0, 1]])
        x, y, z = frame[:3, 3]
        flange = np.asarray(servo.flange(jnp.float32(joints))[0])
        np.testing.assert_allclose([y, -x, z], flange, atol=2e-3)  # theirs are rounded to 0.1 mm


def without(*names):
    return lambda columns: {key: x for key, x in columns.items() if key not in names}


def change(name, make):
    return lambda columns: {**columns, name: make(columns[name])}


def put(name, row, value):
    def make(values):
        values = values.copy()
        values[row] = value
        return values

    return change(name, make)


BAD = {
    "no time": (without("time"), r"no column time \(time, s\)"),
    "no joint": (without("joint_pos_3"), r"no column joint_pos_3 \(joint_pos, rad\)"),
    "no object": (without("object_z"), "no column object_z"),
    "half a velocity": (without("joint_vel_5"), "no column joint_vel_5"),
    "half a command": (without("target_y"), "no column target_y"),
    "no command": (
        without("target_x", "target_y", "target_z", "target_yaw", "target_opening"),
        "neither action_0 to action_4 nor commanded poses",
    ),
    "NaN": (put("joint_pos_2", 7, np.nan), "joint_pos_2 is not a number in row 7"),
    "infinity": (put("object_x", 9, np.inf), "object_x is not a number in row 9"),
    "degrees": (
        change("joint_pos_1", np.degrees),
        "joint_pos_1 is .*: its unit is rad; is it degr",
    ),
    "degrees per second": (change("joint_vel_0", np.degrees), "joint_vel_0 is .*degrees per sec"),
    "millimetres": (change("object_y", lambda x: 1000 * x), "object_y is 420 .* is it millimetres"),
    "percent": (change("gripper_opening", lambda x: 100 * x), "gripper_opening is .* percent"),
    "quaternion": (
        change("object_qw", lambda x: 0.5 * x),
        "quaternion has length 0.5., not|in row",
    ),
    "time goes back": (put("time", 20, 1000.1), "time goes back by .* s in row 20"),
    "time stands still": (put("time", 20, 1000.19), "time stands still in row 20"),
    "milliseconds": (
        change("time", lambda x: 1000 * (x - 1000)),
        "rows are 10 s apart: time must be in seconds",
    ),
    "microseconds": (change("time", lambda x: (x - 1000) / 1000), "more often than any robot"),
    "two clocks": (
        change("time", lambda x: np.where(x > 1001, x + 1.7e9, x)),
        "time jumps by 1.7e.* s in row .*: a gap, or two clocks",
    ),
    "joints of another clock": (
        change("joint_vel_0", lambda x: np.roll(x, len(x) // 2)),
        "joint_vel is not what joint_pos changes by|joint_vel is",
    ),
    "another frame": (
        change("target_y", lambda x: x - 0.9),
        "what is commanded is 0.9. m from the gripper .*base frame",
    ),
    "another place": (change("object_y", lambda x: x + 1.0), "the object is never within 1.1 m"),
    "too short": (lambda columns: {key: x[:2] for key, x in columns.items()}, "0.01 s long"),
    "one row": (lambda columns: {key: x[:1] for key, x in columns.items()}, "has 1 rows"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_log_is_told_in_one_line(table, write, tmp_path, case):
    spoil, complaint = BAD[case]
    columns = commanded(table())
    if case == "joints of another clock":
        moving = {f"joint_vel_{place}" for place in range(1, 6)}
        columns |= {name: np.roll(columns[name], len(columns[name]) // 2) for name in moving}
    file = write(tmp_path / "log.csv", spoil(columns))
    with pytest.raises(UserError, match=complaint) as told:
        prepare(str(file), tables.read(file))
    assert "\n" not in str(told.value)
    assert str(file) in str(told.value)


TORN = {
    "empty.csv": ("", "no column time"),
    "ragged.csv": ("time,a\n1,2\n3\n", "1 cells in row 1, under 2 names"),
    "twice.csv": ("time,time\n1,2\n", "two columns named 'time'"),
    "words.csv": ("time,joint_pos_0\nnow,x\n", "no column joint_pos_1"),
    "torn.parquet": ("PAR1 no more", "torn.parquet is torn"),
    "log.txt": ("time\n1\n", r"does not end in .csv or .parquet"),
}


@pytest.mark.parametrize("name", TORN)
def test_a_torn_file_is_told_in_one_line(tmp_path, name):
    content, complaint = TORN[name]
    if name.endswith(".parquet"):
        pytest.importorskip("pyarrow")
    (tmp_path / name).write_text(content)
    with pytest.raises(UserError, match=complaint):
        prepare(name, tables.read(tmp_path / name))


def test_actions_cannot_be_resampled(table):
    with pytest.raises(UserError, match=r"actions are moves of 0.05 s, and rows are 0.01 s apart"):
        prepare("log", table())
    episode = prepare("log", table(20))
    np.testing.assert_allclose(episode.actions[5], [0, 0.1, 0.2, 0.3, 0.4])
