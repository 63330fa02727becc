"""XLA's faulty reductions are off, in whatever order pigbench and JAX are imported."""

import os
import subprocess
import sys
import textwrap

import jax
import pytest

from pigbench import xla

SUMS = textwrap.dedent(
    """
    import jax
    import jax.numpy as jnp
    rows = jnp.zeros((32_769, 3), jnp.float32).at[:, 0].set(jnp.arange(32_769))
    squares = jax.jit(jax.vmap(lambda row: jnp.sum((jnp.eye(3) @ row) ** 2)))
    print(float(squares(rows)[-1]))
    """
)
# 40412: crashes instead.
SEVEN_AXES = textwrap.dedent(
    """
    import jax
    import jax.numpy as jnp
    ones = jnp.ones((3, 1, 2, 2, 8, 8, 8))
    print(float(jax.jit(lambda a, b: jnp.sum(a * b, axis=3))(ones, ones).sum()))
    """
)


def run(program: str) -> subprocess.CompletedProcess[str]:
    """The program in a process that compiles it, with no flags but those that pigbench sets."""
    kept = os.environ.keys() - {"XLA_FLAGS", "JAX_COMPILATION_CACHE_DIR"}
    environment = {name: os.environ[name] for name in kept}
    command = [sys.executable, "-W", "always", "-c", program]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)


@pytest.mark.parametrize(
    "program, result",
    [
        ("import pigbench" + SUMS, 32_768**2),
        ("import jax; import pigbench" + SUMS, 32_768**2),
        ("import pigbench" + SEVEN_AXES, 3 * 2 * 2 * 8**3),
    ],
    ids=["sums", "sums-jax-first", "seven-axes"],
)
def test_sums_are_right(program, result):
    process = run(program)
    assert process.returncode == 0, process.stderr
    assert float(process.stdout) == pytest.approx(result, rel=1e-6)
    assert "jaxlib" not in process.stderr


def test_one_line_where_jax_ran_first(monkeypatch, recwarn):
    jax.devices()
    monkeypatch.setattr(xla.importlib.metadata, "version", lambda _: "0.10.2")
    monkeypatch.setenv("XLA_FLAGS", "--xla_backend_optimization_level=0")
    xla.avoid_wrong_sums()
    (warning,) = recwarn
    assert "import pigbench first" in str(warning.message)
    assert os.environ["XLA_FLAGS"] == "--xla_backend_optimization_level=0"
