"""Logs of episodes that the simulator played, read back as what they were."""

import json

import jax
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pigbench import cli, envs
from pigbench.data import dataset, logs
from pigbench.data.logs import lerobot
from pigbench.envs.control import effector
from pigbench.envs.reality import Reality
from pigbench.envs.units import ACTION_SCALE
from pigbench.errors import UserError

pyarrow, parquet = (pytest.importorskip(name) for name in ("pyarrow", "pyarrow.parquet"))

EPISODES, STEPS = 2, 12
IMPORT = ["data", "import", "--format", "log", "--environment", "cube-centre"]
NAMES = {
    "observation.state": [
        "shoulder_pan_joint.pos",
        "shoulder_lift_joint.pos",
        "elbow_joint.pos",
        "wrist_1_joint.pos",
        "wrist_2_joint.pos",
        "wrist_3_joint.pos",
        *[f"joint_vel_{place}" for place in range(6)],
        "gripper.pos",
        "gripper_contact",
    ],
    "observation.environment_state": ["x", "y", "z", "qw", "qx", "qy", "qz"],
    "action": ["x", "y", "z", "yaw", "gripper"],
}


@pytest.fixture(scope="module")
def played():
    """What the simulator says: observations, actions, and the table of each of EPISODES."""
    env = envs.make("cube-centre", reality=Reality())
    keys = jax.random.split(jax.random.key(5), EPISODES)
    actions = jax.random.uniform(jax.random.key(6), (STEPS, EPISODES, 5), minval=-1.0)

    @jax.jit
    def play(keys, actions):
        def step(state, action):
            hand = jax.vmap(lambda one: effector(env.scene, one))(state)
            row = jax.vmap(env.observe)(state), state.qpos, state.qvel, hand
            return jax.vmap(env.simulate)(state, action), row

        return jax.lax.scan(step, jax.vmap(env.random_scene)(keys), actions)[1]

    observations, qpos, qvel, hand = jax.device_get(play(keys, actions))
    tables = []
    for number in range(EPISODES):
        target = hand[:, number] + actions[:, number] * np.array(ACTION_SCALE)
        tables.append(
            as_log(env, observations[:, number], qpos[:, number], qvel[:, number], target)
        )
    return env, observations, actions, tables


def as_log(env, observations, qpos, qvel, target) -> dict[str, np.ndarray]:
    """The columns that a UR5e's driver would have written: in the base frame, whose y is our x."""
    to_base = Rotation.from_euler("z", 90, degrees=True)
    cube = qpos[:, env.scene.cubes_qpos]
    pos = to_base.apply(cube[:, :3])
    quat = (to_base * Rotation.from_quat(cube[:, [4, 5, 6, 3]])).as_quat()[:, [3, 0, 1, 2]]
    commanded = to_base.apply(target[:, :3])
    columns = {"time": 7.0 + 0.05 * np.arange(STEPS)}
    columns |= {f"joint_pos_{place}": qpos[:, place] for place in range(6)}
    columns |= {f"joint_vel_{place}": qvel[:, place] for place in range(6)}
    columns["gripper_opening"] = observations[:, env.layout["gripper_opening"]][:, 0] / 3
    columns["gripper_contact"] = observations[:, env.layout["gripper_contact"]][:, 0]
    columns |= dict(zip(("object_x", "object_y", "object_z"), pos.T, strict=True))
    columns |= dict(zip([f"object_q{axis}" for axis in "wxyz"], quat.T, strict=True))
    columns |= dict(zip([f"target_{axis}" for axis in "xyz"], commanded.T, strict=True))
    columns["target_yaw"] = np.mod(target[:, 3] + np.pi / 2 + np.pi, 2 * np.pi) - np.pi
    columns["target_opening"] = np.clip(target[:, 4], 0.0, 1.0)
    return columns


def write_lerobot(folder, tables) -> None:
    rows = [(number, columns) for number, columns in enumerate(tables)]

    def joined(names, renamed):
        return [
            list(map(float, row))
            for _, columns in rows
            for row in zip(*(columns[renamed(name)] for name in names), strict=True)
        ]

    state = [
        *[f"joint_pos_{place}" for place in range(6)],
        *NAMES["observation.state"][6:12],
        "gripper_opening",
        "gripper_contact",
    ]
    targets = ["target_x", "target_y", "target_z", "target_yaw", "target_opening"]
    content = {
        "observation.state": joined(state, str),
        "observation.environment_state": joined(
            NAMES["observation.environment_state"], "object_{}".format
        ),
        "action": joined(targets, str),
        "timestamp": [t for _, columns in rows for t in columns["time"] - 7.0],
        "episode_index": [number for number, columns in rows for _ in columns["time"]],
    }
    data = folder / "data" / "chunk-000"
    data.mkdir(parents=True)
    parquet.write_table(pyarrow.table(content), data / "file-000.parquet")
    features = {
        name: {"dtype": "float32", "shape": [len(names)], "names": names}
        for name, names in NAMES.items()
    }
    features["action"]["names"] = {"motors": NAMES["action"]}
    info = {"codebase_version": "v3.0", "robot_type": "UR5e", "fps": 20, "features": features}
    (folder / "meta").mkdir()
    (folder / "meta" / "info.json").write_text(json.dumps(info))


@pytest.mark.parametrize("form", ["csv", "parquet", "lerobot"])
def test_what_was_played_comes_back(played, tmp_path, write, form):
    env, observations, actions, tables = played
    source, out = tmp_path / "logs", tmp_path / "out"
    source.mkdir()
    if form == "lerobot":
        write_lerobot(source, tables)
    for number, columns in enumerate(tables):
        if form == "csv":
            write(source / f"{number}.csv", columns)
        if form == "parquet":
            parquet.write_table(pyarrow.table(columns), source / f"{number}.parquet")
    cli.run([*IMPORT, str(source), "--out", str(out)])
    assert not dataset.verify(out)
    split = dataset.load(out).split("train")
    assert split.spec.is_imported
    assert split.spec.layout == env.layout
    np.testing.assert_array_equal(split.episode_ends, [STEPS - 1, 2 * STEPS - 1])
    ours = split.concatenate("observations").reshape(EPISODES, STEPS, -1)
    theirs = np.swapaxes(observations, 0, 1)
    quat = env.layout["cube_0_quat"]
    ours[..., quat] *= np.sign(np.sum(ours[..., quat] * theirs[..., quat], -1, keepdims=True))
    yaw = env.layout["effector_yaw"]  # of the pinch point 2 ms ago, as OGBench has it
    np.testing.assert_allclose(ours[..., yaw], theirs[..., yaw], atol=0.02)
    ours[..., yaw] = theirs[..., yaw]
    np.testing.assert_allclose(ours, theirs, atol=2e-5)
    moves = split.concatenate("actions").reshape(EPISODES, STEPS, 5)
    expected = np.swapaxes(actions, 0, 1)
    np.testing.assert_allclose(moves[..., :4], expected[..., :4], atol=0.05)  # likewise


def info(**changes) -> dict:
    features = {name: {"names": names, "shape": [len(names)]} for name, names in NAMES.items()}
    return {"codebase_version": "v3.0", "robot_type": "ur5e", "features": features} | changes


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (info(codebase_version="v2.1"), "has LeRobot's format v2.1: only v3.0 is read"),
        (info(robot_type="so100"), "is of a robot 'so100': a UR5e's is read"),
        (info(features={}), "has no feature observation.state"),
        (
            info(features={name: {"names": None, "shape": [5]} for name in NAMES}),
            "does not name the elements of observation.state",
        ),
        (info(), "has no data/chunk-000/file-000.parquet"),
    ],
)
def test_a_lerobot_folder_that_is_no_ur5es_is_told_in_one_line(tmp_path, content, complaint):
    (tmp_path / "meta").mkdir()
    (tmp_path / "meta" / "info.json").write_text(json.dumps(content))
    assert lerobot.is_dataset(tmp_path)
    with pytest.raises(UserError, match=complaint):
        list(lerobot.read(tmp_path))


@pytest.mark.parametrize("missing", ["timestamp", "episode_index", "action"])
def test_a_file_of_lerobots_must_have_its_columns(tmp_path, missing):
    (tmp_path / "meta").mkdir()
    (tmp_path / "meta" / "info.json").write_text(json.dumps(info()))
    content = {name: [[0.0] * len(names)] for name, names in NAMES.items()}
    content |= {"timestamp": [0.0], "episode_index": [0]}
    del content[missing]
    data = tmp_path / "data" / "chunk-000"
    data.mkdir(parents=True)
    parquet.write_table(pyarrow.table(content), data / "file-000.parquet")
    with pytest.raises(UserError, match=f"has no column {missing}"):
        list(lerobot.read(tmp_path))


@pytest.mark.parametrize(
    ("environment", "names", "complaint"),
    [
        ("cube-double", ["log.csv"], "cube-double has 2 cubes: a log tells of one object"),
        ("cube-centre", [], "holds no log: no .csv, no .parquet"),
        ("cube-centre", ["a/log.csv", "b/log.csv"], "two logs are named log.csv: rename one"),
    ],
)
def test_what_is_no_episode_of_the_environment_is_refused(
    tmp_path, table, write, environment, names, complaint
):
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        write(tmp_path / name, table(20))
    paths = [str(tmp_path / name) for name in names] or [str(tmp_path)]
    out = tmp_path / "out"
    command = ["data", "import", "--format", "log", "--environment", environment]
    with pytest.raises(UserError, match=complaint):
        cli.run([*command, *paths, "--out", str(out)])
    assert not out.exists()


def test_a_tenth_is_for_validation_and_oddities_are_told(tmp_path, table, write, capsys):
    source = tmp_path / "logs"
    source.mkdir()
    for number in range(10):
        columns = {name: values[::5].copy() for name, values in table().items()}
        columns["joint_pos_5"] += number * 1e-3
        if number == 3:
            columns = {name: np.delete(values, slice(8, 12)) for name, values in columns.items()}
            columns["object_x"][20] += 0.2
        write(source / f"{number}.csv", columns)
    out = tmp_path / "out"
    cli.run([*IMPORT, str(source), "--out", str(out)])
    data = dataset.load(out)
    assert data.spec.episodes == {"train": 9, "val": 1}
    last = data.split("val").concatenate("observations")
    assert last[0, 5] == pytest.approx(0.3 + 9e-3, abs=1e-6)
    printed = capsys.readouterr().out
    assert "3.csv: a gap of 0.25 s at 0.35 s is bridged" in printed
    assert "3.csv: the object moves by more than 5 cm in 2 steps, first at 1.15 s" in printed
    assert list(json.loads((out / logs.REPORT).read_text())) == [str(source / "3.csv")]
