"""The 1-D pick-and-place example: an agent at x_a fetches an object at x_o.

States are (x_a, x_o); the mode is h. The goal is to hold the object at 0. Without contact, the
agent moves alone; once it has reached the object, it grasps it at a cost of 1; then both move
together. d* is that of "A 1-D illustrative example" in the paper; in the holding mode, it is
defined on the whole square, though only states with x_a = x_o can be reached.
"""

import jax.numpy as jnp
from jaxtyping import Float

from pigbench.shapes import Array
from pigbench.toy.problem import STEP, Costs, Example, Mode, States, ToySection


def free_cost(states: States) -> Costs:
    """|x_a - x_o| + 1 + |x_o|: reach, grasp, transport."""
    agent, object_ = states.T
    return jnp.abs(agent - object_) + 1 + jnp.abs(object_)


def holding_cost(states: States) -> Costs:
    """|x_a|: transport."""
    return jnp.abs(states[:, 0])


def reach(states: States) -> States:
    """The agent moves towards the object, which stays."""
    agent, object_ = states.T
    return jnp.stack([agent + jnp.clip(object_ - agent, -STEP, STEP), object_], axis=-1)


def transport(states: States) -> States:
    """The agent moves towards the goal, and the object with it."""
    return states + jnp.clip(-states[:, :1], -STEP, STEP)


def free_kinks(states: States) -> Float[Array, "batch"]:
    """Distance from the lines x_a = x_o and x_o = 0."""
    agent, object_ = states.T
    return jnp.minimum(jnp.abs(agent - object_) / jnp.sqrt(2), jnp.abs(object_))


HYBRID = Example(
    axes=("agent $x_a$", "object $x_o$"),
    fits=(
        (
            Mode(
                name="no contact",
                cost_to_go=free_cost,
                successor=reach,
                kink_distance=free_kinks,
                section=ToySection("object $x_o$ (agent at {0:g})", (0.5, -1.0), (0.5, 1.0)),
            ),
            Mode(
                name="holding",
                cost_to_go=holding_cost,
                successor=transport,
                kink_distance=holding_cost,
                section=ToySection("agent and object $x_a = x_o$", (-1.0, -1.0), (1.0, 1.0)),
            ),
        ),
    ),
)
