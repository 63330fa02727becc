"""Full-dimensional anisotropic motion, as in the paper's Prop. eikonal_fully_controllable.

s' = (c u_1, u_2 / c) with ||u|| <= 1 and c = sqrt(r): the feasible velocities form an ellipse with
the area of the unit disc and axes in the ratio r : 1. With the goal at 0,
d* = ||(s_1 / c, c s_2)||, and the optimal motion is straight.
"""

import jax.numpy as jnp
import numpy as np

from pigbench.agents.norms import safe_norm
from pigbench.toy.problem import STEP, Costs, Example, Mode, States, ToySection

RATIOS = 1, 2, 4
"""Ratios of the larger speed to the smaller; 1 is isotropic."""


def mode(ratio: float) -> Mode:
    """Motion with the ratio of speeds r = `ratio`."""
    slownesses = np.array([ratio**-0.5, ratio**0.5], np.float32)

    def cost_to_go(states: States) -> Costs:
        return safe_norm(states * slownesses)

    def successor(states: States) -> States:
        time = jnp.maximum(cost_to_go(states), STEP)
        return states * (1 - STEP / time)[:, None]

    return Mode(
        name=f"speeds {ratio:g} : 1",
        cost_to_go=cost_to_go,
        successor=successor,
        kink_distance=safe_norm,
        section=ToySection("$s_2$, from fast to slow axis", (1.0, 0.0), (0.0, 1.0)),
    )


ANISOTROPY = Example(axes=("fast $s_1$", "slow $s_2$"), fits=tuple((mode(r),) for r in RATIOS))
