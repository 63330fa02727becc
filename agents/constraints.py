"""Constraints that bound QRL's distances: a dual variable holds the mean violation at a margin.

Violations are squared, one per example; `losses.lagrangian` has the dual variable.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import jax

from pigbench.agents import losses
from pigbench.agents.directions import DIRECTIONS, Direction
from pigbench.agents.regularizers import OWN, ValueFunction, gradient_norm, hjb_residual
from pigbench.errors import lookup, require


@dataclass(frozen=True)
class Constraint:
    """The violation whose mean must not exceed `margin`, and its constants.

    Raises `UserError` if `kind` is not in `VIOLATIONS` or a constant is out of range.
    """

    kind: str = "transition"  # transition, eikonal or hjb
    margin: float = 0.05  # the mean violation allowed
    speed: float = 1.0  # S(s) of the Eikonal equation, the same in all states
    epsilon: float = 1e-6  # of the HJB direction, to keep it finite where nothing moves
    direction: str = "own"  # of HJB: own, raw, standardized or positions

    def __post_init__(self) -> None:
        lookup("constraint", VIOLATIONS, self.kind)
        lookup("direction", DIRECTIONS, self.direction)
        require(self, lambda x: x >= 0, "at least 0", "margin")
        require(self, lambda x: x > 0, "positive", "speed", "epsilon")

    def __call__(
        self,
        value: ValueFunction,
        states: jax.Array,
        next_states: jax.Array,
        step_distances: jax.Array,
        direction: Direction = OWN,
    ) -> jax.Array:
        """The violations, (B,). `value` is -d(., g); `step_distances` are d(s, s'), (B,).

        `direction` is the field of that name as resolved in the agent's coordinates.
        """
        return VIOLATIONS[self.kind](self, value, states, next_states, step_distances, direction)


def step_violation(step_distances: jax.Array) -> jax.Array:
    """relu(d(s, s') - 1)^2: a step costs 1, so consecutive states are at most 1 apart."""
    return losses.hinge(step_distances - 1)


def eikonal_violation(
    value: ValueFunction, states: jax.Array, *, speed: jax.Array | float
) -> jax.Array:
    """relu(||grad_s d|| S(s) - 1)^2: penalises gradients larger than the Eikonal equation's."""
    _, norms = gradient_norm(value, states)
    return losses.hinge(norms * speed - 1)


VIOLATIONS: Mapping[
    str,
    Callable[[Constraint, ValueFunction, jax.Array, jax.Array, jax.Array, Direction], jax.Array],
] = {
    "transition": lambda constants, value, states, next_states, steps, _: step_violation(steps),
    "eikonal": lambda constants, value, states, *_: eikonal_violation(
        value, states, speed=constants.speed
    ),
    "hjb": lambda constants, value, states, next_states, _, direction: hjb_residual(
        value, states, next_states, epsilon=constants.epsilon, direction=direction
    )[1],
}
"""Violations by name. To add one, write a function above and add a row here."""
