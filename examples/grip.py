"""Two measures of an evaluation episode: the peak force, and for how long a cube was held."""

from pigbench.evaluation.measures import Fold, Measure, register

register(
    Measure("peak_force", "peak force", lambda at: at.pad_force, Fold.MOST, kind=float, scale=1.0)
)
register(
    Measure("held_steps", "held (steps)", lambda at: at.held.any(), Fold.TOTAL, kind=int, scale=1.0)
)
