"""Engine `mjx-jax`, for TPUs and other accelerators: MJX in pure JAX."""

# mujoco's compiled modules carry no types.
# pyright: reportAttributeAccessIssue=false

from functools import cache
from typing import Any

import jax.numpy as jnp

from pigbench.envs.physics.mjx import MjxPhysics
from pigbench.envs.scene import Scene

# Of MJX's solver in JAX, and of its line search, which looks at three points in each. C needs 13 at
# most in OGBench's play, and 31 points; in single precision some go on to the default's 100.
_ITERATIONS = 20


class MjxJax(MjxPhysics):
    """MJX in pure JAX. On a CPU only for a few environments: it compiles long and runs slowly."""

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
        """MJX takes an actuator at its force limit for one that still damps; C does not."""
        data = self._mjx.forward(model, data)
        low, high = self.scene.model.actuator_forcerange.T
        at_limit = (data.actuator_force <= low) | (data.actuator_force >= high)
        gains = jnp.where(at_limit[:, None], 0.0, model.actuator_biasprm)
        return self._mjx.implicit(model.replace(actuator_biasprm=gains), data)


@cache
def _mend_line_search() -> None:
    """Keep MJX's solver from stopping early in single precision.

    Its line search expands the square of a contact's tangential velocity in the step length. Where
    a contact sticks, the sum can round to less than zero, whose root is no number, and every
    candidate is refused. The constant term is enlarged by what rounding may take away.
    """
    from mujoco.mjx._src import solver

    evaluate: Any = solver._LSPoint.create
    rounding = 16 * float(jnp.finfo(jnp.float32).eps)

    def evaluate_safely(*arguments: Any) -> Any:
        *others, squares, v0, uv, vv = arguments
        return evaluate(*others, squares * (1 + rounding), v0, uv, vv)

    solver._LSPoint.create = evaluate_safely
