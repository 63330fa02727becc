"""Numbers are the same, and there are numbers at all, whatever JAX is set to."""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import pytest

from pigbench import cli, envs, seeds
from pigbench.data import manifest
from pigbench.errors import UserError

SMALL = [
    *("--episodes", "2", "--validation-episodes", "1"),
    *("--episode-length", "11", "--episodes-per-shard", "2"),
]


@contextlib.contextmanager
def otherwise():
    """Each of the settings in question the other way round."""
    with (
        jax.enable_x64(True),
        jax.threefry_partitionable(False),
        jax.numpy_dtype_promotion("strict"),
        jax.numpy_rank_promotion("raise"),
        jax.default_prng_impl("rbg"),
    ):
        yield


@pytest.mark.parametrize("users_own_key", [False, True])
@pytest.mark.parametrize("name", ["cube-double", "cube-centre"])
def test_environments_step_in_single_precision(name, users_own_key):
    env = envs.make(name)
    with otherwise():
        key = jax.random.key(0) if users_own_key else seeds.key(0)
        state = jax.eval_shape(env.reset, key)
        state = jax.eval_shape(env.step, state, jnp.zeros(5))  # as a user's policy acts then
        keys = {"uint32"} if env.reality else set()
        assert {leaf.dtype for leaf in jax.tree.leaves(state)} == {
            jnp.dtype(name) for name in ("float32", "int32", "bool", *keys)
        }


@pytest.mark.parametrize("name", ["cube-single", "cube-centre"])
def test_commands_write_the_same(name, tmp_path):
    def generate(out: Path) -> manifest.Manifest:
        cli.run(["generate", name, "--policy", "play", "--out", str(out), *SMALL])
        return manifest.read(out)  # the files' SHA-256 is in it

    plain = generate(tmp_path / "plain")
    with otherwise():
        assert plain == generate(tmp_path / "otherwise")


def test_a_manifest_tells_what_bits_may_still_depend_on(tmp_path, monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", "--xla_force_host_platform_device_count=1")
    small = [*SMALL[2:], "--episodes", "1", "--out", str(tmp_path)]
    with jax.default_matmul_precision("high"), jax.enable_x64(True):
        cli.run(["generate", "cube-single", *small])
    assert manifest.read(tmp_path).spec.settings == {
        "platform": "cpu",
        "precision": "single",  # which a command sees to
        "matmul_precision": "high",
        "XLA_FLAGS": "--xla_force_host_platform_device_count=1",
    }
    monkeypatch.setenv("XLA_FLAGS", "")
    with jax.default_matmul_precision("high"), pytest.raises(UserError, match=r"settings.XLA_FLA"):
        cli.run(["generate", "cube-single", *small])


def test_commands_that_do_without_jax_still_do():
    code = "from pigbench import cli; cli.run(['list', 'envs']); print('jax' in cli.sys.modules)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.splitlines()[-1] == "False"


def test_what_imports_jax_only_when_it_runs_starts_with_its_defaults():
    code = """
import dataclasses
from pigbench import cli

@dataclasses.dataclass
class Late:
    def run(self):
        import jax
        import jax.numpy as jnp

        bits = jax.random.bits(jax.random.key(0, impl="threefry2x32"), (3,))
        print(jnp.arange(3) * 1.5 + jnp.ones((2, 1)), bits, jnp.zeros(1, float).dtype)

cli.script(Late)
"""
    others = {
        "JAX_ENABLE_X64": "1",
        "JAX_THREEFRY_PARTITIONABLE": "0",
        "JAX_NUMPY_DTYPE_PROMOTION": "strict",
        "JAX_NUMPY_RANK_PROMOTION": "raise",
    }
    plain, otherwise = (
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | settings,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for settings in ({}, others)
    )
    assert "float32" in plain
    assert plain == otherwise
