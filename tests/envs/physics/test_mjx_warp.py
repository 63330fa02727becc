"""Batches over Warp on the CPU, and the room that they have."""

import importlib.util

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.envs import physics as engines
from pigbench.envs.physics import mjx_warp
from pigbench.envs.physics.mjx_warp import MjxWarp
from pigbench.errors import UserError


@pytest.fixture(scope="module")
def warp(scene, situations):
    """The engine on two cubes, and its states of a batch of three."""
    physics = MjxWarp(scene(2))
    return physics, jax.jit(jax.vmap(physics.init))(*situations[:2])


def test_vmaps_within_vmaps_are_one_batch(warp, situations):
    physics, states = warp
    ctrl = situations[2]
    flat = jax.jit(jax.vmap(physics.step))(states, ctrl)
    nested = jax.jit(jax.vmap(jax.vmap(physics.step)))(
        *jax.tree.map(lambda x: x[:, None], (states, ctrl))
    )
    for one, other in zip(jax.tree.leaves(flat), jax.tree.leaves(nested), strict=True):
        np.testing.assert_allclose(np.squeeze(other, axis=1), one, atol=1e-5)


def test_a_simulation_that_diverges_is_flagged_alone(warp, situations):
    physics, states = warp
    broken = situations[2].copy()
    broken[1, 3] = np.nan
    after = jax.jit(jax.vmap(physics.step))(states, broken)
    assert list(after.diverged) == [False, True, False]
    assert not after.overflow.any()
    np.testing.assert_array_equal(after.qpos[1], states.qpos[1])


@pytest.mark.parametrize("room", [{"_GRASP_CONTACTS": 1, "_CUBE_CONTACTS": 1}, {"_ROWS": 0}])
def test_want_of_room_for_contacts_or_rows_is_reported(monkeypatch, capfd, scene, situations, room):
    for name, size in room.items():
        monkeypatch.setattr(mjx_warp, name, size)
    physics = MjxWarp(scene(2))
    states = jax.jit(jax.vmap(physics.init))(*situations[:2])
    after = jax.jit(jax.vmap(physics.step))(states, situations[2])
    assert after.overflow.any()
    np.testing.assert_array_equal(after.diverged, after.overflow)
    assert "overflow" not in capfd.readouterr().out  # the flag says it, Warp need not
    with pytest.warns(RuntimeWarning, match=f"contacts of {after.overflow.sum()} simulations"):
        engines.warn_of_overflow(after)


def test_room_grows_with_cubes_and_simulations(scene):
    def sizes(cubes: int, simulations: int) -> tuple[int, int]:
        data = MjxWarp(scene(cubes))._make_data(simulations)
        return data._impl.naconmax, data._impl.njmax

    contacts, rows = sizes(1, 1)
    assert sizes(1, 64) == (64 * contacts, rows)
    assert sizes(4, 1)[0] > contacts
    assert sizes(4, 1)[1] > rows


def test_warp_must_be_installed(monkeypatch, scene):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"pip install 'pigbench\[warp\]'"):
        MjxWarp(scene(1))


def test_states_of_one_engine_go_on_in_another(warp, scene, situations):
    _, states = warp
    mujoco_physics = engines.make("mujoco", scene(2))
    after = jax.jit(jax.vmap(mujoco_physics.step))(states, jnp.asarray(situations[2]))
    assert not after.diverged.any()
