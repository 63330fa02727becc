"""Differential equations that a value should satisfy, and their residuals.

A residual is that of a value function of the state only, with goals already bound. It comes with
the values, so that a value loss needs no second forward pass. Nothing here depends on the network
or the space: V may be a negative distance, and the state a low-level representation.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Float

from pigbench.agents import directions
from pigbench.agents.directions import DIRECTIONS, Coordinates, Direction
from pigbench.agents.norms import safe_norm
from pigbench.errors import lookup, require
from pigbench.shapes import Array

ValueFunction = Callable[[Float[Array, "batch n"]], Float[Array, "batch"]]
ValuesAndResiduals = tuple[Float[Array, "batch"], Float[Array, "batch"]]
OWN = Direction()


class Transitions(NamedTuple):
    """Transitions as an agent sees them."""

    states: Float[Array, "batch n"]
    next_states: Float[Array, "batch n"]
    coordinates: Coordinates  # of both


def gradient_norm(
    value: ValueFunction, states: Float[Array, "batch n"]
) -> tuple[Float[Array, "batch"], Float[Array, "batch"]]:
    """V(s) and ||grad_s V(s)||."""
    values, pullback = jax.vjp(value, states)
    (gradients,) = pullback(jnp.ones_like(values))
    return values, safe_norm(gradients)


def eikonal_residual(
    value: ValueFunction, states: Float[Array, "batch n"], *, speed: Float[Array, "batch"] | float
) -> ValuesAndResiduals:
    """(||grad_s V|| S(s) - 1)^2, the Eikonal residual; `speed` is S(s).

    See "Physics-informed GCRL" in the paper.
    """
    values, norms = gradient_norm(value, states)
    return values, (norms * speed - 1) ** 2


def hjb_residual(
    value: ValueFunction,
    states: Float[Array, "batch n"],
    next_states: Float[Array, "batch n"],
    *,
    epsilon: float,
    direction: Direction = OWN,
) -> ValuesAndResiduals:
    """(grad_s d . u + 1)^2 with d = -V, the contact-aware HJB residual.

    u is the `direction` of motion, by default (s' - s) / (||s' - s|| + epsilon); see "Contact-aware
    physics-informed value learning" in the paper. The slope along u is a forward-mode derivative,
    which one pass computes together with the value.
    """
    movement = direction(states, next_states, epsilon=epsilon)
    values, slopes = jax.jvp(value, (states,), (movement,))
    return values, (1 - slopes) ** 2


@dataclass(frozen=True)
class Eikonal:
    """The Eikonal equation, ||grad_s V|| S(s) = 1. Raises `UserError` if S is not positive."""

    speed: float = 1.0  # S(s) of the Eikonal equation, the same in all states

    def __post_init__(self) -> None:
        require(self, lambda x: x > 0, "positive", "speed")

    def residuals(self, value: ValueFunction, transitions: Transitions) -> ValuesAndResiduals:
        """V(s) and the residual at s."""
        return eikonal_residual(value, transitions.states, speed=self.speed)


@dataclass(frozen=True)
class HJB:
    """The HJB equation along observed motion. Raises `UserError` if a constant is out of range."""

    epsilon: float = 1e-6  # of the HJB direction, to keep it finite where nothing moves
    direction: str = "own"  # of HJB: own, raw, standardized or positions

    def __post_init__(self) -> None:
        lookup("direction", DIRECTIONS, self.direction)
        require(self, lambda x: x > 0, "positive", "epsilon")

    def residuals(self, value: ValueFunction, transitions: Transitions) -> ValuesAndResiduals:
        """V(s) and the residual at s."""
        direction = directions.make(self.direction, transitions.coordinates)
        states, next_states, _ = transitions
        return hjb_residual(value, states, next_states, epsilon=self.epsilon, direction=direction)
