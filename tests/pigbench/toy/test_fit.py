import jax
import numpy as np
import pytest

from pigbench.errors import UserError
from pigbench.toy.fit import LOSSES, fit, predict
from pigbench.toy.problem import Mode, ToySection
from pigbench.toy.settings import Settings

RAMP = Mode(
    name="ramp",
    cost_to_go=lambda states: 2 * states[:, 0],
    successor=lambda states: states - np.array([0.01, 0.0]),
    kink_distance=lambda states: states[:, 0],
    section=ToySection("", (-1.0, 0.0), (1.0, 0.0)),
)
FEW = Settings(steps=5, batch_size=8, hidden_sizes=(4,))


def fitted(loss, seeds, settings, report=lambda amount: None):
    return fit([RAMP], LOSSES[loss], seeds=seeds, settings=settings, report=report)


@pytest.mark.parametrize("loss", ["hjb", "eikonal"])
def test_a_fit_is_the_minimiser_of_regression_and_residual(loss):
    """By hand: of (d - 2 x)^2 + (d' - 1)^2 on [-1, 1] it is d = 2 x - sinh(x) / cosh(1).

    (Euler's equation is d - 2 x = d'', with d' = 1 at the ends.)
    """
    settings = Settings(steps=1500, batch_size=64, hidden_sizes=(32,), learning_rate=1e-2)
    (params,) = [jax.tree.map(lambda leaf: leaf[0], fitted(loss, [0], settings))]
    states = np.stack([np.linspace(-1, 1, 9), np.linspace(0.7, -0.7, 9)], axis=-1)
    expected = 2 * states[:, 0] - np.sinh(states[:, 0]) / np.cosh(1)
    np.testing.assert_allclose(predict(settings, params, 0, states), expected, atol=0.03)


def test_a_seed_gives_the_same_fit_alone_and_among_others():
    several = fitted("hjb", [3, 4], FEW)
    alone = fitted("hjb", [4], FEW)
    jax.tree.map(
        lambda all_, one: np.testing.assert_allclose(all_[1], one[0], rtol=1e-4, atol=1e-6),
        several,
        alone,
    )
    kernel = jax.tree.leaves(several)[1]
    assert not np.allclose(kernel[0], kernel[1])


def test_every_update_is_reported():
    amounts = []
    fitted("baseline", [0], Settings(steps=130, batch_size=2, hidden_sizes=(2,)), amounts.append)
    assert amounts == [100, 30]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"steps": 0}, "steps is 0: it must be at least 1"),
        ({"half_width": 0.0}, "half_width is 0.0: it must be positive"),
        ({"hidden_sizes": (4, 0)}, "hidden_sizes is .*: it must be positive numbers"),
    ],
)
def test_impossible_settings_are_named(settings, message):
    with pytest.raises(UserError, match=message):
        Settings(**settings)
