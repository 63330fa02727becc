"""The mended line search of MJX in JAX: only within our calls, and only where it is known."""

import numpy as np
import pytest

from pigbench.envs.physics import mjx_jax
from pigbench.envs.physics.mjx_jax import MjxJax
from pigbench.errors import UserError


@pytest.fixture
def point():
    from mujoco.mjx._src import solver

    return solver._LSPoint


def test_the_line_search_of_others_stays_as_it_is(point, scene):
    original = vars(point)["create"]
    MjxJax(scene(1, "fast"))
    with pytest.raises(ZeroDivisionError), mjx_jax._mended_line_search():
        assert vars(point)["create"] is not original
        raise ZeroDivisionError
    assert vars(point)["create"] is original


@pytest.mark.parametrize("other", [lambda m, d, ctx, alpha: None, None])
def test_an_unknown_line_search_is_refused(monkeypatch, point, scene, other):
    monkeypatch.setattr(point, "create", other)
    with pytest.raises(UserError, match=r"install 3\.17, or choose another engine"):
        MjxJax(scene(1, "fast"))


def test_rounding_that_the_constant_term_makes_up_for(monkeypatch, point):
    """The square of a velocity u + alpha v, expanded as MJX does, where the two cancel out."""
    draws = np.random.default_rng(0)
    alpha = draws.uniform(0.1, 1, 100_000).astype(np.float32)
    u = draws.normal(size=(2, len(alpha))).astype(np.float32)
    v = -u / alpha
    uu, uv, vv = (u * u).sum(0), (u * v).sum(0), (v * v).sum(0)
    seen = []
    monkeypatch.setattr(point, "create", lambda *arguments: seen.append(arguments))
    with mjx_jax._mended_line_search():
        point.create(*"mdcajqg", uu, None, uv, vv)
    ((*others, mended, _, same_uv, same_vv),) = seen
    assert "".join(others) == "mdcajqg"
    assert same_uv is uv
    assert same_vv is vv

    def square(constant):
        return constant + alpha * (2 * uv + alpha * vv)

    assert (square(uu) < 0).mean() > 0.1
    assert (square(mended) >= 0).all()
