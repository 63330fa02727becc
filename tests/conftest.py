"""Set before any test imports JAX: tests compile much and compute little."""

import os

import pytest

os.environ["XLA_FLAGS"] = f"--xla_backend_optimization_level=0 {os.environ.get('XLA_FLAGS', '')}"


@pytest.fixture(scope="session")
def drawing() -> None:
    """Skips where nothing can be drawn."""
    from pigbench.envs.rendering import Renderer
    from pigbench.errors import UserError

    pytest.importorskip("av")
    try:
        with Renderer(1, width=64, height=48):
            pass
    except UserError as error:
        pytest.skip(str(error))
