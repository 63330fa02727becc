"""Picks and places on the C engine, which a control step must agree with."""

import numpy as np

from pigbench import envs
from pigbench.bench import picking
from pigbench.bench.picking import Picks


def test_the_policy_places_cubes_and_a_step_is_that_of_c(monkeypatch):
    env = envs.make("cube-single")
    picks = picking.pick_and_place(env, 2)
    assert picks.placed.all()
    assert len(picks.qpos) == len(picks.ctrl) > 50
    height = picks.qpos[:, env.scene.cubes_qpos][:, 2]
    assert height.max() > 0.05 > height[0]  # it was carried
    errors = picking.step_errors(env, picks)
    assert errors.arm.max() < 1e-6
    assert errors.cube.max() < 1e-6
    # Controls that are a little off are seen.
    shifted = picks._replace(ctrl=picks.ctrl + np.float32(1e-3))
    monkeypatch.setattr(picking, "_in_c", lambda scene, _, c=picking._in_c: c(scene, picks))
    assert picking.step_errors(env, shifted).arm.max() > 1e-5


def test_a_cube_is_placed_near_its_target_in_a_simulation_that_is_sound():
    unseen = np.zeros((0, 1))
    picks = Picks(np.array([0.01, 0.05, 0.01]), np.array([False, False, True]), *3 * [unseen])
    assert list(picks.placed) == [True, False, False]
