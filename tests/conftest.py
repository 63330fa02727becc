"""Set before any test imports JAX: tests compile much and compute little."""

import contextlib
import dataclasses
import functools
import gc
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_args

import jaxtyping
import pytest
from jaxtyping import install_import_hook, jaxtyped

install_import_hook(
    "pigbench", "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))"
)


def _check_arrays(**options: Any) -> Callable:
    """The hook's decorator, for what functions take and return of arrays.

    Other arguments may be a test's stand-ins, and JAX makes dataclasses of batches and shapes too.
    """
    check = jaxtyped(**options)

    def decorated(made: Any) -> Any:
        if isinstance(made, type):
            return made
        made.__annotations__ = {k: v for k, v in made.__annotations__.items() if _has_array(v)}
        return check(made)

    return decorated


def _has_array(hint: Any) -> bool:
    if isinstance(hint, type) and issubclass(hint, jaxtyping.AbstractArray):
        return True
    return any(map(_has_array, get_args(hint)))


jaxtyping.jaxtyped = _check_arrays

# The older emitters make programs in half the processor time, which are about as fast.
OLDER = "--xla_cpu_use_fusion_emitters=false"
FLAGS = f"--xla_backend_optimization_level=0 {OLDER}"
os.environ["XLA_FLAGS"] = f"{FLAGS} {os.environ.get('XLA_FLAGS', '')}"


# What is compiled once is compiled for all of a session's processes. Set here, because folders'
# conftest.py may import JAX before pytest is configured.
if "PYTEST_XDIST_WORKER" not in os.environ:  # workers have the environment of their session
    _cache = tempfile.TemporaryDirectory(prefix="pigbench-compiled-")  # removed when Python ends
    os.environ["JAX_COMPILATION_CACHE_DIR"] = _cache.name
    os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"
    _paths = [str(Path(__file__).with_name("python")), os.environ.get("PYTHONPATH")]
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, _paths))
gc.set_threshold(100_000)  # compiled programs stay, and would be gone through again and again
sys.modules.pop("warp", None)  # workers began as any process that tests start, but need Warp


@pytest.fixture(scope="session")
def short_episodes() -> Callable[[], contextlib.AbstractContextManager[None]]:
    """`with short_episodes()`: all environments' episodes end after 6 control steps."""
    from pigbench import envs

    @contextlib.contextmanager
    def short() -> Iterator[None]:
        specs = {
            name: dataclasses.replace(one, episode_length=6) for name, one in envs.SPECS.items()
        }
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(envs, "SPECS", specs)
            yield

    return short


@pytest.fixture
def short(short_episodes) -> Iterator[None]:
    """A test's episodes are short."""
    with short_episodes():
        yield


@pytest.fixture(scope="module")
def users_emitters() -> Iterator[None]:
    """Programs, also those of other processes, are made by the emitters that users have.

    The older ones round the same computation otherwise in one program than in another.
    """
    import jax

    options = {"xla_cpu_use_fusion_emitters": True}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(jax, "jit", functools.partial(jax.jit, compiler_options=options))
        patch.setenv("XLA_FLAGS", os.environ["XLA_FLAGS"].replace(OLDER, ""))
        yield


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
