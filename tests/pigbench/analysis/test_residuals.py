"""Residuals of value functions whose gradients are known."""

import jax
import numpy as np
import pytest

from pigbench.agents import (
    GCIVL,
    EikonalRegularizer,
    FlowHierarchy,
    FlowHierarchyConfig,
    GoalMixture,
    HJBRegularizer,
    Sampling,
    Statistics,
)
from pigbench.agents.directions import Coordinates
from pigbench.analysis.residuals import by_mode, measure
from pigbench.data.sampler import Rows
from pigbench.layout import Layout, Space

EIKONAL = EikonalRegularizer(speed=2.0)
RAW = HJBRegularizer(epsilon=1e-9, direction="raw")
LAYOUT = Layout.of({"effector_pos": 3, "gripper_contact": 1, "cube_0_pos": 3})
SLOPES = np.array([0.0, 3.0, 0.0, 0.0, 4.0, 0.0, 0.0])
STEP = np.array([0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0])


class Linear:
    """V(s, g) = slopes . (s - g)."""

    layout = LAYOUT
    sampling = Sampling(
        value_goals=GoalMixture(0.0, 1.0, 0.0, geometric=False),
        actor_goals=GoalMixture(0.0, 1.0, 0.0, geometric=False),
        discount=0.9,
    )

    def __init__(self, penalty, units=1.0):
        self.penalty = penalty
        self.coordinates = Coordinates(LAYOUT, statistics=None, units=units)

    def value_learner(self, params, batch):
        return self, params, batch

    def state_value(self, params, observation, goal):
        return (observation - goal) @ params


class Sum(GCIVL):
    """V(x, g) = sum(x) - ||x - g||^2 / 2, trained with goals where the state is."""

    sampling = Sampling(
        value_goals=GoalMixture(1.0, 0.0, 0.0, geometric=False),
        actor_goals=GoalMixture(0.0, 1.0, 0.0, geometric=False),
        discount=0.9,
    )

    def state_value(self, params, observation, goal):
        return (observation - (observation - goal) ** 2 / 2).sum()


@pytest.fixture
def rows() -> Rows:
    """An episode that moves by `STEP`; in its second half the cube is between the fingers."""
    states = np.arange(40)[:, None] * STEP
    states[:, 4:7] = states[:, :3] + np.where(np.arange(40) < 20, 1.0, 0.1)[:, None]
    states[20:, 3] = 1.0
    # The cube's jump between the halves is no motion along STEP: an episode ends there.
    ends = np.isin(np.arange(40), [19, 39])
    return Rows.create(states.astype(np.float32), np.zeros((40, 5), np.float32), ends)


def test_residuals_of_a_linear_value(rows):
    """Norm 5; of its square 9 parts in 25 along the robot; the slope along the motion by hand."""
    modes, residuals = measure(Linear(EIKONAL), SLOPES, rows, samples=300, seed=0)
    assert set(modes) == {"free", "holding"}
    np.testing.assert_allclose(residuals.gradient, 5.0, rtol=1e-6)
    np.testing.assert_allclose(residuals.eikonal, (2 * 5 - 1) ** 2, rtol=1e-6)
    np.testing.assert_allclose(residuals.robot, 9 / 25, rtol=1e-6)
    np.testing.assert_allclose(residuals.object, 16 / 25, rtol=1e-6)
    _, residuals = measure(Linear(RAW), SLOPES, rows, samples=300, seed=0)
    np.testing.assert_allclose(residuals.eikonal, (5 - 1) ** 2, rtol=1e-6)
    # Robot and cube both move by 0.5 in y: u = (0, 1, 0, 0, 0, 1, 0) / sqrt(2), slope 3 / sqrt(2).
    np.testing.assert_allclose(residuals.hjb, (1 - 3 / np.sqrt(2)) ** 2, rtol=1e-4)


def test_motion_is_measured_in_what_the_agent_measures_it_in(rows):
    """In units in which only the robot moves, by 0.5: u = (0, 1, 0, 0, 0, 1, 0), slope 3."""
    robot = np.array([1, 1, 1, 0, 0, 0, 0])
    _, residuals = measure(Linear(RAW, units=robot), SLOPES, rows, samples=300, seed=0)
    np.testing.assert_allclose(residuals.hjb, (1 - 3) ** 2, rtol=1e-4)


def test_a_hierarchy_is_measured_as_its_low_level_is_trained(rows):
    """In its own coordinates, with its own goals: the slope is 1 along each coordinate."""
    hierarchy = FlowHierarchy(
        FlowHierarchyConfig(subgoal_steps=2),
        Space(LAYOUT, 5),
        low=Sum,
        statistics=Statistics.of(rows.observations),
    )
    params = hierarchy.init(jax.random.key(0))
    _, residuals = measure(hierarchy, params, rows, samples=100, seed=0)
    np.testing.assert_allclose(residuals.gradient, np.sqrt(hierarchy.represent.size), rtol=1e-5)


def test_a_value_that_is_flat_has_no_shares(rows):
    modes, residuals = measure(Linear(RAW), np.zeros(7), rows, samples=10, seed=0)
    np.testing.assert_allclose(residuals.eikonal, 1.0)
    assert np.isnan(residuals.object).all()
    assert all(len(values) == 0 for values in by_mode(modes, residuals.object).values())
