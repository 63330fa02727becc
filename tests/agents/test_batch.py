import numpy as np
import pytest

from pigbench.agents import Batch, GoalMixture, Sampling, SubgoalSampling


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
