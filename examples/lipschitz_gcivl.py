"""GCIVL with a regulariser of one's own: values may change by at most 1 per unit of the state."""

from dataclasses import dataclass

import jax.numpy as jnp

from pigbench import agents
from pigbench.agents.residuals import gradient_norm


@dataclass(frozen=True)
class Lipschitz:
    """Like the Eikonal residual, but only slopes that are too steep count."""

    bound: float = 1.0  # the largest norm of the gradient that is free
    weight: float = 1.0  # of the residual in the loss

    def residuals(self, value, transitions):
        """V(s), and what the loss adds: relu(||grad_s V|| - bound)^2."""
        values, norms = gradient_norm(value, transitions.states)
        return values, jnp.maximum(norms - self.bound, 0) ** 2


@dataclass(frozen=True)
class LipschitzGCIVLConfig(agents.GCIVLConfig):
    """Hyperparameters: those of GCIVL, with this regulariser instead of the others."""

    regularizer: Lipschitz = Lipschitz()


agents.register(
    agents.Method(
        name="lipschitz-gcivl",
        agent=agents.GCIVL,
        config=LipschitzGCIVLConfig(),
        summary="GCIVL with values of bounded slope",
    )
)
