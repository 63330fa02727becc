import numpy as np
import pytest

from pigbench.agents import Batch, GoalMixture, Sampling, SubgoalSampling
from pigbench.errors import UserError


@pytest.mark.parametrize(
    "shares", [(0.5, 0.5, 0.5), (0.2, 0.3, 0.4), (1.5, -0.5, 0.0), (float("nan"), 0.5, 0.5)]
)
def test_a_mixture_must_be_a_distribution(shares):
    with pytest.raises(UserError, match="must be three probabilities that sum to 1"):
        GoalMixture(*shares, geometric=True)


def test_rounding_does_not_reject_a_mixture():
    GoalMixture(current=0.1, future=0.2, random=0.7, geometric=True)


@pytest.mark.parametrize(
    ("part", "what"),
    [
        ("value_goals", "value goals"),
        ("value_success", "value goals"),
        ("required_subgoals", "subgoals"),
    ],
)
def test_what_was_not_drawn_is_refused_where_it_is_needed(part, what):
    batch = Batch(*[np.zeros((1, 1))] * 4)
    with pytest.raises(ValueError, match=f"has no {what}: the agent's `sampling` must ask"):
        getattr(batch, part)


def test_subgoals_without_value_goals_are_refused():
    mixture = GoalMixture(current=0.0, future=1.0, random=0.0, geometric=False)
    with pytest.raises(ValueError, match="need value goals"):
        Sampling(None, mixture, 0.9, SubgoalSampling(3, None, 0.9))
