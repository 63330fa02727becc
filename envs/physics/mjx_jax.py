"""Engine `mjx-jax`, for TPUs and other accelerators: MJX in pure JAX."""

# mujoco's compiled modules have no types.
# pyright: reportAttributeAccessIssue=false

import contextlib
import inspect
import threading
from collections.abc import Iterator
from importlib.metadata import version
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from pigbench.envs.physics.base import PhysicsState
from pigbench.envs.physics.mjx import MjxPhysics
from pigbench.envs.scene import Scene
from pigbench.errors import UserError

# The limit of MJX's solver in JAX, and of its line search, which evaluates three points per
# iteration. On OGBench's play data, C needs at most 13 iterations and 31 points; in single
# precision, some solves would run to the default of 100.
_ITERATIONS = 20


# The arguments of MJX's line search, as far as the mended one knows them.
_ARGUMENTS = ("m", "d", "ctx", "alpha", "jv", "quad", "quad_gauss", "uu", "v0", "uv", "vv")


_TRACING = threading.RLock()  # the mended line search is there for all threads


class MjxJax(MjxPhysics):
    """MJX in pure JAX. On a CPU it compiles and runs slowly: use it for a few environments only.

    Raises UserError if the installed MJX is not one whose line search can be mended.
    """

    name = "mjx-jax"
    implementation = "jax"

    def __init__(self, scene: Scene):
        super().__init__(scene)
        _check_line_search()

    def _make_model(self) -> Any:
        limits = {"opt.iterations": _ITERATIONS, "opt.ls_iterations": _ITERATIONS}
        return super()._make_model().tree_replace(limits)

    def _make_data(self, simulations: int) -> Any:
        return self._mjx.make_data(self.scene.model, impl=self.implementation)

    def _simulate(
        self, substeps: int, states: PhysicsState, ctrl: Float[Array, "simulation nu"]
    ) -> PhysicsState:
        with _mended_line_search():
            return super()._simulate(substeps, states, ctrl)

    def _substep(self, model: Any, data: Any) -> Any:
        """A substep in which actuators at their force limit do not damp, as in C but not in MJX."""
        data = self._mjx.forward(model, data)
        low, high = self.scene.model.actuator_forcerange.T
        at_limit = (data.actuator_force <= low) | (data.actuator_force >= high)
        gains = jnp.where(at_limit[:, None], 0.0, model.actuator_biasprm)
        return self._mjx.implicit(model.replace(actuator_biasprm=gains), data)


def _line_search_point() -> Any:
    """MJX's class of the points that its line search evaluates; None if it has gone."""
    from mujoco.mjx._src import solver

    return getattr(solver, "_LSPoint", None)


def _check_line_search() -> None:
    create = getattr(_line_search_point(), "create", None)
    if create is None or tuple(inspect.signature(create).parameters) != _ARGUMENTS:
        raise UserError(
            f"mujoco-mjx {version('mujoco-mjx')} searches along lines in another way than 3.17, "
            "which mjx-jax mends: install 3.17, or choose another engine"
        )


@contextlib.contextmanager
def _mended_line_search() -> Iterator[None]:
    """Keep MJX's solver, where it is traced within the block, from stopping early.

    Its line search expands the square of a contact's tangential velocity in the step length. For a
    sticking contact, rounding to single precision can make the sum negative; its square root is
    then NaN, and every candidate is rejected. The fix enlarges the constant term by the possible
    rounding error. docs/engines.md has a report for MJX's maintainers.
    """
    point = _line_search_point()
    rounding = 16 * float(jnp.finfo(jnp.float32).eps)
    with _TRACING:
        evaluate, original = point.create, vars(point)["create"]

        def evaluate_safely(*arguments: Any) -> Any:
            *others, squares, v0, uv, vv = arguments
            return evaluate(*others, squares * (1 + rounding), v0, uv, vv)

        point.create = evaluate_safely
        try:
            yield
        finally:
            point.create = original
