"""The choice of an engine."""

import importlib.util

import jax
import pytest

from pigbench.envs import physics as engines


@pytest.mark.parametrize(
    ("platform", "has_warp", "expected"),
    [
        ("cpu", True, "mujoco"),
        ("gpu", True, "mjx-warp"),
        ("gpu", False, "mjx-jax"),
        ("tpu", True, "mjx-jax"),
    ],
)
def test_the_engine_follows_from_the_device(monkeypatch, platform, has_warp, expected):
    monkeypatch.setattr(jax, "default_backend", lambda: platform)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object() if has_warp else None)
    assert engines.default_engine() == expected
