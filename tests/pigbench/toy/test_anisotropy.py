import jax
import numpy as np
import pytest
from scipy.optimize import linprog

from pigbench.agents.residuals import eikonal_residual, hjb_residual
from pigbench.toy.anisotropy import ANISOTROPY, RATIOS, mode

STATES = np.array([[0.5, -0.3], [-0.7, 0.2], [0.1, 0.9], [-0.6, 0.0], [0.0, 0.8]])


def velocities(ratio):
    """Of 720 controls on the unit circle, from the speeds: their product is 1, their ratio r."""
    angles = np.arange(720) * np.pi / 360
    return np.stack([np.cos(angles) * ratio**0.5, np.sin(angles) / ratio**0.5])


@pytest.mark.parametrize("ratio", RATIOS)
def test_the_cost_to_go_is_the_least_time_over_all_controls(ratio):
    """A linear programme: how long to apply each control so that the state ends at the origin."""
    controls = velocities(ratio)
    times = [linprog(np.ones(720), A_eq=controls, b_eq=-state).fun for state in STATES]
    np.testing.assert_allclose(mode(ratio).cost_to_go(STATES), times, rtol=1e-4)


@pytest.mark.parametrize("ratio", RATIOS)
def test_the_support_function_of_the_velocities_is_1(ratio):
    gradients = jax.vmap(jax.grad(lambda state: mode(ratio).cost_to_go(state[None])[0]))(STATES)
    np.testing.assert_allclose((-gradients @ velocities(ratio)).max(axis=-1), 1, rtol=1e-4)


@pytest.mark.parametrize("ratio", RATIOS)
def test_optimal_motion_lowers_the_cost_as_fast_as_time_passes_and_stops_at_the_goal(ratio):
    motion = mode(ratio)
    gain = motion.cost_to_go(STATES) - motion.cost_to_go(motion.successor(STATES))
    np.testing.assert_allclose(gain, 0.01, atol=1e-6)
    np.testing.assert_array_equal(motion.successor(np.array([[1e-3, 1e-3], [0, 0]])), 0)


@pytest.mark.parametrize(
    ("ratio", "fast", "slow"), [(1, 0.0, 0.0), (4, (1 - 1 / 2) ** 2, (1 - 2) ** 2)]
)
def test_residuals_on_the_axes_by_hand(ratio, fast, slow):
    """There the gradient is along the motion, its norm 1 / speed: 1 / sqrt(r) and sqrt(r).

    Both residuals ask for the norm 1, which only isotropic motion has.
    """
    states = np.array([[0.6, 0.0], [0.0, 0.8]])
    motion = mode(ratio)

    def value(states):
        return -motion.cost_to_go(states)

    _, eikonal = eikonal_residual(value, states, speed=1.0)
    _, hjb = hjb_residual(value, states, motion.successor(states), epsilon=1e-6)
    np.testing.assert_allclose(eikonal, [fast, slow], atol=1e-5)
    np.testing.assert_allclose(hjb, [fast, slow], atol=2e-3)


def test_each_ratio_is_a_fit_of_its_own():
    assert [[mode.name for mode in modes] for modes in ANISOTROPY.fits] == [
        [f"speeds {ratio} : 1"] for ratio in RATIOS
    ]
