"""Models that differ between simulations, against models that MuJoCo compiles so."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from unittest.mock import Mock

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from pigbench.envs.physics import Factors, make, mujoco
from pigbench.envs.physics.mujoco import MujocoPhysics
from pigbench.envs.reality import Variation, variation
from pigbench.envs.scene import Scene, describe
from pigbench.envs.units import CONTROL_STEP

GRAVITY = 9.81
FACTORS = Factors(friction=jnp.array([0.9, 0.3, 0.6]), mass=jnp.array([1.0, 1.3, 0.7]))


def thrown(engine, speed, *, steps, spin=(0.0, 0.0, 0.0), factors=None):
    """The poses, after each step, of a cube at (0.4, 0) pushed along y: (..., steps, 7)."""
    scene = engine.scene
    place = jnp.array([0.4, 0.0, 0.02, 1.0, 0.0, 0.0, 0.0])
    qpos = jnp.asarray(scene.home_qpos, jnp.float32).at[scene.cubes_qpos].set(place)
    qvel = jnp.zeros(scene.model.nv).at[scene.cubes_qvel].set(jnp.array([0.0, speed, 0.0, *spin]))
    ctrl = jnp.append(qpos[scene.arm], 0.0)

    def episode(factors):
        def step(state, _):
            state = engine.step(state, ctrl)
            return state, state.qpos[scene.cubes_qpos]

        first = replace(engine.init(qpos, qvel), factors=factors)
        return jax.lax.scan(step, first, length=steps)[1]

    return np.asarray(jax.jit(jax.vmap(episode) if factors else episode)(factors))


def compiled_with(friction: float, mass: float) -> Scene:
    spec = describe(1, "exact")
    for pair in spec.pairs:
        pair.friction = friction * np.array(pair.friction)
    (cube,) = spec.body("cube_0").geoms
    cube.density *= mass
    return Scene(spec.compile(), 1, "exact")


def test_each_simulation_has_its_own_model(scene):
    """A cube that spins as it slides into a wall goes as in a model that is compiled so."""
    throw = {"speed": 3.0, "spin": (6.0, 1.0, 3.0), "steps": 8}
    ours = thrown(make("mujoco", scene(1)), factors=FACTORS, **throw)
    for row, friction, mass in zip(ours, FACTORS.friction, FACTORS.mass, strict=True):
        theirs = thrown(make("mujoco", compiled_with(float(friction), float(mass))), **throw)
        np.testing.assert_allclose(row, theirs, atol=1e-6)
    assert np.abs(ours[0] - ours[1]).max() > 0.01


@pytest.mark.parametrize("engine", ["mujoco", "mjx-warp"])
def test_a_cube_slides_as_far_as_friction_lets_it(scene, engine):
    ours = thrown(make(engine, scene(1)), 0.6, steps=6, factors=FACTORS)
    stop = 0.6 / (GRAVITY * np.asarray(FACTORS.friction))
    assert np.all(stop < 6 * CONTROL_STEP)
    np.testing.assert_allclose(ours[:, -1, 1], 0.6 * stop / 2, rtol=0.1)


def test_batches_at_the_same_time_keep_their_models(scene, monkeypatch):
    many = [replace(FACTORS, mass=FACTORS.mass * one) for one in (1.0, 1.1)]

    def thrown_far(engine, factors):
        return thrown(engine, 0.6, steps=20, spin=(0.0, 0.0, 9.0), factors=factors)

    alone = [thrown_far(make("mujoco", scene(1)), factors) for factors in many]
    varied = Mock(wraps=mujoco._vary)
    monkeypatch.setattr(mujoco, "_vary", varied)
    with ThreadPoolExecutor(2) as threads:
        together = list(threads.map(partial(thrown_far, MujocoPhysics(scene(1), threads=3)), many))
    assert not np.array_equal(*alone)
    np.testing.assert_array_equal(together, alone)
    assert varied.call_count == 2  # it sets all constants of every model


def test_factors_are_uniform():
    keys = jax.random.split(jax.random.key(0), 1000)
    drawn = jax.vmap(lambda key: variation.draw(key, Variation(friction=0.5, mass=0.2)))(keys)
    assert stats.kstest(drawn.friction, stats.uniform(0.5, 1.0).cdf).pvalue > 1e-3
    assert stats.kstest(drawn.mass, stats.uniform(0.8, 0.4).cdf).pvalue > 1e-3
    assert abs(np.corrcoef(drawn.friction, drawn.mass)[0, 1]) < 0.1
