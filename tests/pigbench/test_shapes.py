"""That tests check shapes: wrong ones would pass through all of these functions."""

from functools import partial

import jax
import jax.numpy as jnp
import jaxtyping
import numpy as np
import pytest

from pigbench.agents.losses import goal_td_target
from pigbench.analysis.modes import contact_modes
from pigbench.envs.rotations import nearest_turn
from pigbench.training.batches import keys_of

LAYOUT = {"gripper_contact": slice(0, 1), "effector_pos": slice(0, 3)}
CALLS = {
    "agents": partial(goal_td_target, jnp.zeros(1), jnp.zeros(3), discount=0.9),
    "envs": partial(nearest_turn, jnp.zeros((2, 1)), jnp.zeros(2)),
    "integers": partial(nearest_turn, jnp.zeros(2, int), jnp.zeros(2)),
    "training": partial(keys_of, jax.random.key(0), jnp.zeros(())),
    "analysis": partial(contact_modes, np.zeros((2, 3), int), LAYOUT),
}


@pytest.mark.parametrize("package", CALLS)
def test_arrays_of_other_shapes_are_refused(package):
    with pytest.raises(jaxtyping.TypeCheckError):
        CALLS[package]()
