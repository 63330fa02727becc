"""Numbers are the same, and there are numbers at all, whatever JAX is set to."""

import contextlib
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp

from pigbench import cli, envs, seeds
from pigbench.data import manifest

SMALL = ["--episodes", "2", "--validation-episodes", "1", "--episode-length", "11"]


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


def test_environments_step_in_single_precision():
    env = envs.make("cube-double")
    with otherwise():
        state = jax.eval_shape(env.reset, seeds.key(0))
        state = jax.eval_shape(env.step, state, jnp.zeros(5))  # as a user's policy acts then
        assert {leaf.dtype for leaf in jax.tree.leaves(state)} == {
            jnp.dtype(name) for name in ("float32", "int32", "bool")
        }


def test_commands_write_the_same(tmp_path):
    def generate(out: Path) -> manifest.Manifest:
        cli.run(["generate", "cube-single", "--out", str(out), *SMALL])
        return manifest.read(out)  # the files' SHA-256 is in it

    plain = generate(tmp_path / "plain")
    with otherwise():
        assert plain == generate(tmp_path / "otherwise")


def test_commands_that_do_without_jax_still_do():
    code = "from pigbench import cli; cli.run(['list', 'envs']); print('jax' in cli.sys.modules)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.splitlines()[-1] == "False"
