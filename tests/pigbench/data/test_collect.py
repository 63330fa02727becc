"""Generated data: reproducible to the byte, whole episodes only, dropped ones counted."""

import hashlib
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import cli, envs
from pigbench.data import collect, dataset, manifest
from pigbench.data.manifest import Spec
from pigbench.data.writer import Writer
from pigbench.envs.environment import CubeEnv
from pigbench.envs.observation import cube_poses
from pigbench.envs.oracles import PlayPolicy, ScriptedPolicy
from pigbench.envs.physics.mujoco import MujocoPhysics
from pigbench.envs.scene import build
from pigbench.envs.scripted import Scripted
from pigbench.envs.units import metres

pytestmark = pytest.mark.usefixtures("users_emitters")


def spec(env: CubeEnv, **changes) -> Spec:
    settings = {
        "environment": "cube-double",
        "policy": "play",
        "physics": "exact",
        "engine": "mujoco",
        "seed": 3,
        "episodes": {"train": 5, "val": 1},
        "episodes_per_shard": 4,
        "rows_per_episode": 21,
        "fields": collect.FIELDS,
        "layout": env.layout,
        "action_size": env.action_size,
        "versions": {},
    }
    return Spec(**settings | changes)


def digests(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def generate(folder: Path, env: CubeEnv, policy: ScriptedPolicy, **changes) -> Path:
    settings = spec(env, **changes)
    source = collect.local_source(env, policy, settings)
    collect.write_missing(env, policy, settings, Writer(folder, settings), source)
    return folder


def test_as_many_shards_as_the_engine_can_use_are_under_way(monkeypatch):
    monkeypatch.setattr(collect, "_LONGEST_CHUNK", 1)
    scene = build(2)
    env = CubeEnv(envs.SPECS["cube-double"], MujocoPhysics(scene, 2))
    settings = spec(env, episodes={"train": 8, "val": 8})
    both = threading.Barrier(2)
    source = collect.local_source(env, PlayPolicy(env.spec, scene), settings)
    simulated = source(settings.plan(), lambda shard, steps: both.wait(timeout=60))
    assert {shard for shard, _ in simulated} == {*settings.plan()}


def test_what_is_no_longer_wanted_stops(monkeypatch):
    """As when the disk is full: the command must end, and Python waits for threads."""
    env = envs.make("cube-double")
    monkeypatch.setattr(collect, "_LONGEST_CHUNK", 1)
    monkeypatch.setattr(env.physics, "batches_at_once", 2)
    settings, closed, told = spec(env), threading.Event(), Counter()
    first, second = settings.plan()[:2]

    def tell(shard, steps):
        told[shard] += steps
        if shard == second:
            closed.wait(timeout=60)

    source = collect.local_source(env, PlayPolicy(env.spec, env.scene), settings)
    simulated = source((first, second), tell)
    assert next(simulated)[0] == first
    simulated.close()
    closed.set()
    for thread in threading.enumerate():
        if thread.name.startswith("simulate"):
            thread.join(timeout=60)
    assert told == {first: 21, second: 1}


def test_bytes_do_not_depend_on_the_number_of_threads(tmp_path):
    spec, scene = envs.SPECS["cube-double"], build(2)
    for threads in (1, 2):
        env = CubeEnv(spec, MujocoPhysics(scene, threads))
        generate(tmp_path / str(threads), env, PlayPolicy(spec, scene))
    assert digests(tmp_path / "1") == digests(tmp_path / "2")


def test_an_episode_replays_in_the_environment(tmp_path):
    env = envs.make("cube-double")
    split = dataset.load(generate(tmp_path, env, PlayPolicy(env.spec, env.scene))).split("train")
    observations, actions = split.concatenate("observations"), split.concatenate("actions")
    qpos, qvel = split.concatenate("qpos"), split.concatenate("qvel")
    assert observations.shape == (5 * 21, 37)
    assert np.abs(actions).max() <= 1
    ends = np.flatnonzero(split.concatenate("terminals"))
    np.testing.assert_array_equal(ends, 21 * np.r_[1:6] - 1)
    state = env.physics.init(qpos[42], qvel[42])  # an episode's first row, at rest
    simulate = jax.jit(env.simulate)
    for row in range(42, 62):
        np.testing.assert_allclose(state.qpos, qpos[row], atol=1e-6)
        np.testing.assert_allclose(env.observe(state), observations[row], atol=1e-5)
        state = simulate(state, actions[row])


class Breaking(PlayPolicy):
    """Asks for the impossible in the episodes whose first draw is above a half."""

    def act(self, key, state, physics_state):
        action = super().act(key, state, physics_state)
        return jnp.where(state.stacking > 0.125, jnp.nan, action)


def test_diverged_episodes_are_dropped_and_counted(tmp_path):
    env = envs.make("cube-double")
    whole = generate(tmp_path / "whole", env, PlayPolicy(env.spec, env.scene))
    some = generate(tmp_path / "some", env, Breaking(env.spec, env.scene))
    records = manifest.read(some).shards
    dropped = sum(record.dropped for record in records)
    assert 0 < dropped < 6
    assert sum(record.episodes for record in records) == 6 - dropped
    assert not dataset.verify(some)
    # What is left is what would have been there anyway.
    kept = dataset.load(some).split("train").concatenate("qpos").reshape(-1, 21, 28)
    everything = dataset.load(whole).split("train").concatenate("qpos").reshape(-1, 21, 28)
    for episode in kept:
        assert any(np.array_equal(episode, other) for other in everything)


def test_a_killed_generation_is_resumed_to_the_same_bytes(tmp_path):
    options = [
        *("generate", "cube-single", "--episodes", "12", "--validation-episodes", "1"),
        *("--episode-length", "101", "--episodes-per-shard", "2"),
    ]
    cli.run([*options, "--out", str(tmp_path / "whole")])
    cut = tmp_path / "cut"
    command = [sys.executable, "-c", "from pigbench.cli import main; main()"]
    process = subprocess.Popen([*command, *options, "--out", str(cut)], stderr=subprocess.DEVNULL)
    while not list(cut.glob("train-*/qvel.npy")) and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL, "the generation ended before it could be killed"
    cli.run([*options, "--out", str(cut)])
    assert digests(tmp_path / "whole") == digests(cut)


class Looking(PlayPolicy):
    """Tells where it sees the cube, and ends an episode after 3 rows, or after 6."""

    ability = Scripted(episode_rows=6)

    def act(self, key, state, physics_state):
        return jnp.zeros(5).at[:3].set(cube_poses(self.scene, physics_state)[0][0])

    def finished(self, state):
        return state.time == jnp.where(state.target.yaw < jnp.pi, 2, 5)


def test_a_policy_knows_estimates_and_may_end_episodes(tmp_path):
    env = envs.make("cube-centre")
    changes = {"environment": "cube-centre", "rows_per_episode": 0}
    folder = generate(tmp_path / "data", env, Looking(env.spec, env.scene), **changes)
    assert not dataset.verify(folder)
    split = dataset.load(folder).split("train")
    lengths = np.diff(split.episode_ends, prepend=-1)
    assert set(lengths) == {3, 6}
    estimates = metres(split.concatenate("observations")[:, env.layout["cube_0_pos"]])
    cubes = split.concatenate("qpos")[:, env.scene.cubes_qpos][:, :3]
    np.testing.assert_allclose(split.concatenate("actions")[:, :3], estimates, atol=1e-6)
    errors = np.linalg.norm(estimates - cubes, axis=-1)
    assert 1e-4 < errors.min() < np.median(errors) < 0.03
