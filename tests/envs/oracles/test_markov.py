"""The phases against OGBench's Markov oracle, on situations drawn around its every threshold."""

import jax
import numpy as np
import pytest
from ogbench.manipspace.oracles.markov.cube_markov import CubeMarkovOracle

from pigbench.envs.oracles import markov
from pigbench.envs.oracles.targets import Target

DRAWS = 3000


def draw(rng: np.random.Generator) -> tuple[markov.OracleInputs, Target, markov.Pose]:
    """Things in the workspace, each often near another, so that every phase comes up."""

    def somewhere(near: np.ndarray, spread: float) -> np.ndarray:
        anywhere = rng.uniform([0.25, -0.35, 0.02], [0.6, 0.35, 0.35])
        beside = near + rng.uniform(-spread, spread, 3)
        return np.float32(anywhere if rng.random() < 0.3 else beside)

    cube = rng.uniform([0.3, -0.3, 0.02], [0.55, 0.3, 0.3]).astype(np.float32)
    goal = somewhere(cube, 0.03)
    hand = somewhere(cube, 0.03)
    final = somewhere(hand, 0.04)
    yaws = rng.uniform(-np.pi, np.pi, 4).astype(np.float32)
    contact = np.float32(rng.choice([0.0, rng.random(), 1.0]))
    return (
        markov.OracleInputs(hand, yaws[0], contact, cube, yaws[1]),
        Target(cube=np.int32(0), pos=goal, yaw=yaws[2]),
        markov.Pose(final, yaws[3]),
    )


def test_decides_as_ogbenchs_oracle(ogbench_env):
    oracle = CubeMarkovOracle(env=ogbench_env("cube-single"))
    phases = []
    oracle.print_phase = phases.append
    rng = np.random.default_rng(0)
    drawn = [draw(rng) for _ in range(DRAWS)]
    expected, done = [], []
    for situation, target, final in drawn:
        info = {
            "proprio/effector_pos": situation.effector_pos,
            "proprio/effector_yaw": [situation.effector_yaw],
            "proprio/gripper_opening": [0.0],
            "proprio/gripper_contact": situation.contact,
            "privileged/target_block": 0,
            "privileged/block_0_pos": situation.cube_pos,
            "privileged/block_0_yaw": [situation.cube_yaw],
            "privileged/target_block_pos": target.pos,
            "privileged/target_block_yaw": [target.yaw],
        }
        oracle._done, oracle._step = False, 0
        oracle._final_pos, oracle._final_yaw = final.pos, final.yaw
        expected.append(oracle.select_action(None, info))
        done.append(oracle.done)
    assert min(phases.count(phase) for phase in set(phases)) >= 10
    assert len(set(phases)) == 9
    assert 10 < sum(done) < DRAWS / 2
    stacked = jax.tree.map(lambda *values: np.stack(values), *drawn)
    ours = jax.jit(jax.vmap(markov.action))(*stacked)
    np.testing.assert_allclose(ours, np.array(expected), atol=2e-5)
    np.testing.assert_array_equal(jax.vmap(markov.done)(*stacked), done)


def test_gives_up_when_ogbenchs_oracle_does(ogbench_env):
    oracle = CubeMarkovOracle(env=ogbench_env("cube-single"))
    oracle.reset(None, None)
    assert oracle._max_step == markov.MAX_STEPS


@pytest.mark.parametrize("gap", [0.0, 0.01])
def test_at_its_destination_an_action_is_finite(gap):
    """Right above the cube: down by the least distance, 5 * 0.4 clipped to 1."""
    cube = np.float32([0.4, 0.1, 0.02])
    above = cube + np.float32([0, 0, gap])
    situation = markov.OracleInputs(above, np.float32(0), np.float32(0), cube, np.float32(0))
    target = Target(cube=np.int32(0), pos=np.float32([0.5, -0.1, 0.02]), yaw=np.float32(0))
    final = markov.Pose(np.float32([0.4, 0, 0.3]), np.float32(0))
    ours = jax.jit(markov.action)(situation, target, final)
    np.testing.assert_allclose(ours, [0, 0, -1 if gap else 0, 0, 1], atol=1e-6)
