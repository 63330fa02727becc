"""The examples, small: the very scripts, on a few rows and updates."""

import copy
import re
from pathlib import Path

import jax
import jax.numpy as jnp
import matplotlib.image
import mujoco
import numpy as np
import pytest

from pigbench import cli, envs, seeds
from pigbench.agents.residuals import Transitions
from pigbench.data import dataset
from pigbench.envs import physics
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.runs.restore import restore

FEW = ["--episodes", "1", "--steps", "2", "--evaluation-episodes", "1"]
TRAIN = "--preset cpu --agent.batch-size 8 --agent.actor-hidden-sizes 8 --steps 1"
EVALUATE = "--evaluate-every 1 --evaluation.episodes 1"


@pytest.fixture(scope="module")
def compared(run, examples, short_episodes, tmp_path_factory) -> Path:
    """A method of the package and one of an example, compared."""
    out = tmp_path_factory.mktemp("compared")
    methods = ["--methods", "gcivl", "huber-bc", "--plugin", examples / "huber_bc.py"]
    where = ["--out", out, "--data", out / "data"]
    with short_episodes():
        run("compare_methods", *where, *methods, *FEW, "--evaluate-every", "2", "--seeds", "0")
    return out


def test_methods_are_compared(compared):
    table = (compared / "table.md").read_text()
    for method in ("gcivl", "huber-bc"):
        assert re.search(rf"^\| {method} +\| ", table, re.M)
    assert "Probability in percent that a run" in table
    assert (compared / "curves.png").exists()


def test_values_are_those_of_the_cubes_places(compared, run, tmp_path):
    """x runs along rows and y along columns, in the state that the map says it is."""
    folder = compared / "gcivl-0"
    example = run("value_map", folder, "--out", tmp_path / "values.png", "--points", "3")
    one = example.value_map(folder, task=4, points=3, seed=0)
    _, env, agent, state = restore(folder)
    goal = jnp.array([[0.5, 0.2, 0.02]])
    np.testing.assert_allclose(one.goal, goal[0, :2])
    start = env.reset_to(
        seeds.key(0), jnp.array([[0.55, 0.0, 0.02]]), goal, yaw=jnp.zeros(1), jitter=0.0
    )
    expected = agent.state_value(state.acting, start.obs, start.info["goal"])
    np.testing.assert_allclose(one.values[2, 1], expected, rtol=1e-4)
    assert np.ptp(one.values) > 0
    assert (tmp_path / "values.png").exists()


def test_the_controller_succeeds_through_gymnasium(run, tmp_path):
    run("gymnasium_control", "--out", tmp_path, "--episodes", "2", "--every", "30")
    lines = (tmp_path / "results.txt").read_text().splitlines()
    assert len(lines) == 5
    assert all(": 100 % of 2 episodes succeed" in line for line in lines)
    height, width, _ = matplotlib.image.imread(tmp_path / "episode.png").shape
    assert height == 200
    assert width % 204 == 0 and width >= 3 * 204  # the goal, the start and the end


def test_logs_come_back_as_they_were_played(run, short, tmp_path):
    """Through frames, units and a file; and a policy is trained on them."""
    run("own_log", "--out", tmp_path, *FEW, "--method", "gcbc")
    played, imported = (dataset.load(tmp_path / name) for name in ("simulated", "data"))
    for field, tolerance in {"observations": 2e-3, "actions": 1e-6, "terminals": 0}.items():
        np.testing.assert_allclose(
            imported.split("train").concatenate(field),
            played.split("train").concatenate(field),
            atol=tolerance,
        )
    assert re.search(r"^\| cube-centre gcbc +\| ", (tmp_path / "table.md").read_text(), re.M)


def test_a_regulariser_of_a_file_is_trained_with_and_read_back(compared, examples, tmp_path):
    plugin = ["--plugin", str(examples / "lipschitz_gcivl.py")]
    folder, small = tmp_path / "run", f"{TRAIN} {EVALUATE} --agent.value-hidden-sizes 8"
    method = ["lipschitz-gcivl", "--data", str(compared / "data"), "--agent.regularizer.bound", "2"]
    cli.run(["train", *method, "--out", str(folder), *small.split(), *plugin])
    regularizer = restore(folder).agent.penalty
    assert regularizer.bound == 2.0
    slopes = jnp.array([[3.0, 4.0], [0.0, 1.0]])  # of norms 5 and 1
    transitions = Transitions(
        jnp.zeros((2, 2)), jnp.zeros((2, 2)), restore(folder).agent.coordinates
    )
    _, residuals = regularizer.residuals(lambda x: (slopes * x).sum(axis=-1), transitions)
    np.testing.assert_allclose(residuals, [(5 - 2) ** 2, 0], rtol=1e-6)


def test_an_engine_of_a_file_steps_as_mujoco_in_c_with_half_the_timestep(load, monkeypatch):
    monkeypatch.setattr(physics, "ENGINES", dict(physics.ENGINES))
    engine = load("half_steps").HalfSteps.name
    env = envs.make("cube-single", engine=engine)
    state = jax.jit(env.random_scene)(seeds.key(0))
    ctrl = np.asarray(state.qpos[: env.scene.model.nu]) + 0.01
    after = jax.jit(env.physics.step)(state, ctrl)
    model = copy.copy(env.scene.model)
    model.opt.timestep = 0.001
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = state.qpos, state.qvel, state.warmstart
    data.ctrl[:] = ctrl
    mujoco.mj_step(model, data, nstep=50)
    np.testing.assert_array_equal(after.qpos, np.float32(data.qpos))
    assert np.abs(after.qpos - state.qpos).max() > 1e-3
    with pytest.raises(UserError, match=f"{engine}' is already registered: choose another name"):
        load("half_steps")


def test_an_environment_of_a_file_is_generated_and_learned(examples, tmp_path, monkeypatch):
    monkeypatch.setattr(envs, "SPECS", dict(envs.SPECS))
    plugin = ["--plugin", str(examples / "cube_corners.py")]
    data, folder = str(tmp_path / "data"), str(tmp_path / "run")
    generate = ["--episodes", "1", "--validation-episodes", "0", "--episode-length", "11"]
    cli.run(["generate", "cube-corners", "--out", data, *generate, *plugin])
    cli.run(["train", "gcbc", "--data", data, "--out", folder, *(TRAIN + " " + EVALUATE).split()])
    rows = episodes.read(Path(folder) / "episodes.csv")
    assert [row.task_name for row in rows if row.step == 1] == [
        *("task1_near_left", "task2_near_right", "task3_far_left", "task4_far_right")
    ]
    state = jax.jit(envs.make("cube-corners").reset_task)(jax.random.key(0), 3)
    np.testing.assert_allclose(state.info["target"], [[0.525, 0.25, 0.02]])
