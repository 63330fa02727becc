"""Which cube next and where to: OGBench's rule, and the frequencies that follow from it."""

import jax
import numpy as np
import pytest
from scipy import stats

from pigbench import envs
from pigbench.envs import workspace
from pigbench.envs.oracles import targets

LEVEL = 0.04
DRAWS = 4000
draw = jax.jit(jax.vmap(targets.draw, in_axes=(0, None, None)))


def random_scene(rng: np.random.Generator, num_cubes: int) -> np.ndarray:
    """Cubes on the table and on one another, slightly off centre, (num_cubes, 3)."""
    places = rng.uniform([0.3, -0.3], [0.55, 0.3], (2, 2))
    levels = np.zeros(2)
    cubes = []
    for _ in range(num_cubes):
        place = rng.integers(2)
        # Some offsets are just beyond the 2 cm within which a cube counts as on another.
        xy = places[place] + rng.uniform(-0.012, 0.012, 2)
        cubes.append([*xy, 0.02 + LEVEL * levels[place]])
        levels[place] += 1
    return np.array(cubes)[rng.permutation(num_cubes)]


def covered(cubes: np.ndarray, i: int) -> bool:
    """OGBench's words: some other cube is higher and less than 2 cm away in the plane."""
    return any(
        other[2] > cubes[i][2] and np.hypot(*(other[:2] - cubes[i][:2])) < 0.02
        for j, other in enumerate(cubes)
        if j != i
    )


@pytest.mark.parametrize("num_cubes", [1, 2, 3, 4, 8])
def test_is_top(num_cubes):
    rng = np.random.default_rng(num_cubes)
    scenes = np.float32([random_scene(rng, num_cubes) for _ in range(200)])
    found = jax.vmap(targets.is_top)(scenes)
    expected = [[not covered(cubes, i) for i in range(num_cubes)] for cubes in scenes]
    np.testing.assert_array_equal(found, expected)
    if num_cubes > 1:
        assert 0 < np.mean(found) < 1


def test_of_a_stack_only_the_top_cube_is_moved():
    stack = np.array([[0.4, 0.1, 0.06], [0.4, 0.1, 0.02], [0.4, 0.1, 0.1]])
    drawn = draw(jax.random.split(jax.random.key(0), 200), stack, 1.0)
    np.testing.assert_array_equal(drawn.cube, 2)
    # There is no other top cube to stack it on.
    np.testing.assert_allclose(drawn.pos[:, 2], 0.02, atol=1e-7)


def test_frequencies():
    """Two stacks and a single cube: three top cubes, equally likely to move and to be moved to."""
    cubes = np.array(
        [[0.3, 0, 0.02], [0.3, 0, 0.06], [0.5, 0, 0.02], [0.5, 0, 0.06], [0.4, 0.2, 0.02]]
    )
    top, stacking = [1, 3, 4], 0.3
    drawn = draw(jax.random.split(jax.random.key(1), DRAWS), cubes, stacking)
    moved = np.asarray(drawn.cube)
    assert set(moved) == set(top)
    assert stats.chisquare([np.sum(moved == i) for i in top]).pvalue > 1e-3

    pos = np.asarray(drawn.pos, float)
    bases = [np.all(np.abs(pos - cubes[i] - [0, 0, LEVEL]) < 1e-6, axis=-1) for i in top]
    stacked = np.any(bases, axis=0)
    assert stats.binomtest(int(stacked.sum()), DRAWS, stacking).pvalue > 1e-3
    pairs = [np.sum((moved == i) & bases[top.index(j)]) for i in top for j in top if i != j]
    assert stats.chisquare(pairs).pvalue > 1e-3
    assert not any(np.any((moved == i) & bases[top.index(i)]) for i in top)

    floor = pos[~stacked]
    np.testing.assert_allclose(floor[:, 2], 0.02, atol=1e-7)
    for axis in range(2):
        low, high = workspace.CUBE.low[axis], workspace.CUBE.high[axis]
        assert stats.kstest(floor[:, axis], stats.uniform(low, high - low).cdf).pvalue > 1e-3
    assert stats.kstest(drawn.yaw, stats.uniform(0, 2 * np.pi).cdf).pvalue > 1e-3
    # Yaw tells nothing of the rest.
    assert abs(stats.spearmanr(drawn.yaw, stacked).statistic) < 0.05


@pytest.mark.parametrize(("stacking", "expected"), [(0.0, False), (1.0, True)])
def test_never_and_always_stacking(stacking, expected):
    cubes = np.array([[0.3, 0, 0.02], [0.5, 0, 0.02]])
    drawn = draw(jax.random.split(jax.random.key(2), 200), cubes, stacking)
    np.testing.assert_array_equal(drawn.pos[:, 2] > 0.05, expected)


def test_against_ogbenchs_own_draws(ogbench_env):
    """Cubes moved and cubes stacked on, in OGBench's environment at the same scene."""
    env = ogbench_env("cube-quadruple")
    cubes = np.array([[0.3, 0, 0.02], [0.3, 0, 0.06], [0.5, 0, 0.02], [0.4, 0.2, 0.02]])
    qpos = env.data.qpos.copy()
    for i, xyz in enumerate(cubes):
        qpos[14 + 7 * i : 17 + 7 * i] = xyz
    env.set_state(qpos, np.zeros(env.model.nv))
    theirs = []
    for _ in range(2000):
        env.set_new_target(return_info=False, p_stack=0.4)
        target = env.data.mocap_pos[env._cube_target_mocap_ids[env._target_block]]
        theirs.append((env._target_block, round(target[2] / 0.02)))
    drawn = draw(jax.random.split(jax.random.key(3), DRAWS), cubes, 0.4)
    heights = np.round(np.asarray(drawn.pos[:, 2]) / 0.02).astype(int)
    ours = list(zip(np.asarray(drawn.cube), heights, strict=True))
    kinds = sorted(set(theirs))
    assert set(ours) == set(kinds)
    table = [[sum(row == kind for row in rows) for kind in kinds] for rows in (ours, theirs)]
    assert stats.chi2_contingency(table).pvalue > 1e-3


def test_stacking_probabilities_are_ogbenchs():
    ogbench = [spec for spec in envs.SPECS.values() if spec.reality is None]
    assert {spec.num_cubes: spec.stacking for spec in ogbench} == {
        1: (0, 0),
        2: (0, 0.25),
        3: (0.05, 0.35),
        4: (0.1, 0.5),
        8: (0, 0.35),
    }
    assert targets.FIRST_STACKING == 0.5
