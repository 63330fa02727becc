"""Physics-informed regularisers of a value loss: a weight, and a residual that it weighs.

A configuration has one of them. Each kind has its own constants, and computes V(s) and unweighted
residuals by its method `residuals`. To add a kind, write a class and name it in
`Regularizer`.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import jax.numpy as jnp

from pigbench.agents.residuals import HJB, Eikonal, Transitions, ValueFunction, ValuesAndResiduals
from pigbench.errors import require
from pigbench.support.schema import BY_KIND


@dataclass(frozen=True)
class NoRegularizer:
    """No regulariser: residuals are 0."""

    kind: Literal["none"] = "none"  # none, eikonal or hjb

    weight: ClassVar[float] = 0.0

    def residuals(self, value: ValueFunction, transitions: Transitions) -> ValuesAndResiduals:
        """V(s) and 0."""
        values = value(transitions.states)
        return values, jnp.zeros_like(values)


@dataclass(frozen=True)
class EikonalRegularizer(Eikonal):
    """The weighted Eikonal residual. Raises `UserError` if a constant is out of range."""

    weight: float = 1.0  # lambda: the weight of the residual, for a cost of 1, in the loss
    kind: Literal["eikonal"] = "eikonal"  # none, eikonal or hjb

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: x >= 0, "at least 0", "weight")


@dataclass(frozen=True)
class HJBRegularizer(HJB):
    """The weighted HJB residual. Raises `UserError` if a constant is out of range."""

    weight: float = 1.0  # lambda: the weight of the residual, for a cost of 1, in the loss
    kind: Literal["hjb"] = "hjb"  # none, eikonal or hjb

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: x >= 0, "at least 0", "weight")


Regularizer = Annotated[NoRegularizer | EikonalRegularizer | HJBRegularizer, BY_KIND]
