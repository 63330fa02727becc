"""Engine `mjx-jax`, for TPUs and other accelerators: MJX in pure JAX."""

# mujoco's compiled modules have no types.
# pyright: reportAttributeAccessIssue=false

from functools import cache
from typing import Any

import jax.numpy as jnp

from pigbench.envs.physics.mjx import MjxPhysics
from pigbench.envs.scene import Scene

# The limit of MJX's solver in JAX, and of its line search, which evaluates three points per
# iteration. On OGBench's play data, C needs at most 13 iterations and 31 points; in single
# precision, some solves would run to the default of 100.
_ITERATIONS = 20


class MjxJax(MjxPhysics):
    """MJX in pure JAX. On a CPU it compiles and runs slowly: use it for a few environments only."""

    name = "mjx-jax"
    implementation = "jax"

    def __init__(self, scene: Scene):
        super().__init__(scene)
        _mend_line_search()

    def _make_model(self) -> Any:
        limits = {"opt.iterations": _ITERATIONS, "opt.ls_iterations": _ITERATIONS}
        return super()._make_model().tree_replace(limits)

    def _make_data(self, simulations: int) -> Any:
        return self._mjx.make_data(self.scene.model, impl=self.implementation)

    def _substep(self, model: Any, data: Any) -> Any:
        """A substep in which actuators at their force limit do not damp, as in C but not in MJX."""
        data = self._mjx.forward(model, data)
        low, high = self.scene.model.actuator_forcerange.T
        at_limit = (data.actuator_force <= low) | (data.actuator_force >= high)
        gains = jnp.where(at_limit[:, None], 0.0, model.actuator_biasprm)
        return self._mjx.implicit(model.replace(actuator_biasprm=gains), data)


@cache
def _mend_line_search() -> None:
    """Keep MJX's solver from stopping early in single precision.

    Its line search expands the square of a contact's tangential velocity in the step length. For a
    sticking contact, rounding can make the sum negative; its square root is then NaN, and every
    candidate is rejected. The fix enlarges the constant term by the possible rounding error.
    """
    from mujoco.mjx._src import solver

    evaluate: Any = solver._LSPoint.create
    rounding = 16 * float(jnp.finfo(jnp.float32).eps)

    def evaluate_safely(*arguments: Any) -> Any:
        *others, squares, v0, uv, vv = arguments
        return evaluate(*others, squares * (1 + rounding), v0, uv, vv)

    solver._LSPoint.create = evaluate_safely
