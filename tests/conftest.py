"""Set before any test imports JAX: tests compile much and compute little."""

import contextlib
import dataclasses
import functools
import os
import tempfile
from collections.abc import Callable, Iterator
from typing import Any

import jaxtyping
import pytest
from jaxtyping import install_import_hook, jaxtyped

# Calls of these are checked against their annotations, shapes of arrays included. Of others, tests
# replace parts by stand-ins.
CHECKED = (
    "pigbench.agents",
    "pigbench.analysis.modes",
    "pigbench.bench.picking",
    "pigbench.data.dataset",
    "pigbench.data.logs",
    "pigbench.data.mapped",
    "pigbench.data.quality",
    "pigbench.data.selection",
    "pigbench.data.shard",
    "pigbench.envs",
    "pigbench.fidelity.distributions",
    "pigbench.fidelity.peer",
    "pigbench.fidelity.recording",
    "pigbench.fidelity.replay",
    "pigbench.fidelity.tables",
    "pigbench.gym",
    "pigbench.layout",
    "pigbench.report",
    "pigbench.support.pictures",
    "pigbench.toy",
    "pigbench.training.milestones",
)
install_import_hook(CHECKED, "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))")


def _check_functions(**options: Any) -> Callable:
    """The decorator of the hook, without dataclasses: JAX makes them of batches and shapes too."""
    check = jaxtyped(**options)
    return lambda made: made if isinstance(made, type) else check(made)


jaxtyping.jaxtyped = _check_functions

# The older emitters make programs in half the processor time, which are about as fast.
OLDER = "--xla_cpu_use_fusion_emitters=false"
FLAGS = f"--xla_backend_optimization_level=0 {OLDER}"
os.environ["XLA_FLAGS"] = f"{FLAGS} {os.environ.get('XLA_FLAGS', '')}"


def pytest_configure(config: pytest.Config) -> None:
    """What is compiled once is compiled for all of a session's processes."""
    if not hasattr(config, "workerinput"):  # xdist's workers have the environment of their session
        cache = tempfile.TemporaryDirectory(prefix="pigbench-compiled-")
        config.add_cleanup(cache.cleanup)
        os.environ["JAX_COMPILATION_CACHE_DIR"] = cache.name
        os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"


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
