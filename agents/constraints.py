"""Constraints that bound QRL's distances: a dual variable holds the mean violation at a margin.

A configuration has one of them. Each kind has its own constants, and computes squared violations
by its method `violations`; `losses.lagrangian` has the dual variable. To add a kind, write a
class and name it in `Constraint`.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from jaxtyping import Float

from pigbench.agents import losses
from pigbench.agents.residuals import HJB, Eikonal, Transitions, ValueFunction, gradient_norm
from pigbench.errors import require
from pigbench.shapes import Array
from pigbench.support.schema import BY_KIND


@dataclass(frozen=True)
class TransitionConstraint:
    """d(s, s') <= 1: a step costs 1. Raises `UserError` if the margin is negative."""

    margin: float = 0.05  # the mean violation allowed
    kind: Literal["transition"] = "transition"  # transition, eikonal or hjb

    def __post_init__(self) -> None:
        require(self, lambda x: x >= 0, "at least 0", "margin")

    def violations(
        self, value: ValueFunction, transitions: Transitions, step_distances: Float[Array, "batch"]
    ) -> Float[Array, "batch"]:
        """relu(d(s, s') - 1)^2, where `step_distances` are d(s, s')."""
        return losses.hinge(step_distances - 1)


@dataclass(frozen=True)
class EikonalConstraint(Eikonal):
    """||grad_s d|| S(s) <= 1. Raises `UserError` if a constant is out of range."""

    margin: float = 0.05  # the mean violation allowed
    kind: Literal["eikonal"] = "eikonal"  # transition, eikonal or hjb

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: x >= 0, "at least 0", "margin")

    def violations(
        self, value: ValueFunction, transitions: Transitions, step_distances: Float[Array, "batch"]
    ) -> Float[Array, "batch"]:
        """relu(||grad_s d|| S(s) - 1)^2, where `value` is -d(., g)."""
        _, norms = gradient_norm(value, transitions.states)
        return losses.hinge(norms * self.speed - 1)


@dataclass(frozen=True)
class HJBConstraint(HJB):
    """The HJB equation; deviations of either sign count.

    Raises `UserError` if a constant is out of range.
    """

    margin: float = 0.05  # the mean violation allowed
    kind: Literal["hjb"] = "hjb"  # transition, eikonal or hjb

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: x >= 0, "at least 0", "margin")

    def violations(
        self, value: ValueFunction, transitions: Transitions, step_distances: Float[Array, "batch"]
    ) -> Float[Array, "batch"]:
        """The HJB residual of `value`, which is -d(., g)."""
        return self.residuals(value, transitions)[1]


Constraint = Annotated[TransitionConstraint | EikonalConstraint | HJBConstraint, BY_KIND]
