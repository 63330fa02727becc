import numpy as np
import pytest

from pigbench.agents import Batch, GoalMixture
from pigbench.errors import UserError


@pytest.mark.parametrize(
    "shares", [(0.5, 0.5, 0.5), (0.2, 0.3, 0.4), (1.5, -0.5, 0.0), (float("nan"), 0.5, 0.5)]
)
def test_a_mixture_must_be_a_distribution(shares):
    with pytest.raises(UserError, match="must be three probabilities that sum to 1"):
        GoalMixture(*shares, geometric=True)


def test_rounding_does_not_reject_a_mixture():
    GoalMixture(current=0.1, future=0.2, random=0.7, geometric=True)


def test_a_batch_without_subgoals_is_refused_where_they_are_needed():
    with pytest.raises(ValueError, match="has no subgoals"):
        _ = Batch(*[np.zeros((1, 1))] * 6).required_subgoals
