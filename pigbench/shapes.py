"""Arrays, and what the axes in their types are, as in `Float[Array, "batch observation"]`.

An axis is named in the singular, after what one index selects; tests check that in one call, axes
of the same name are as long as each other. Functions without leading axes are for one example or
one simulation: vmap them. Fields of a dataclass that is a pytree have their axes in one simulation.

Axes of many things:

- `batch`: examples, or states apart from their episodes; `*batch` stands for any leading axes, or
  none
- `row`: rows of a data set or of a log
- `time`: control steps of an episode, and `step`: training steps; `{steps}` is that many
- `simulation`, `episode`, `task`, `seed`, `run` and `cube`: each of these
- `joint`: the arm's six joints
- `member`: members of an ensemble; `*member` also for none
- `candidate`: samples, of which one is chosen

Axes of one thing's numbers:

- `observation`: an observation, or a state as an agent sees it
- `goal`: a goal as networks see it (`Agent.as_goals`)
- `action`: an action, or another choice made in a state, such as a subgoal
- `x`: a state or subgoal in a low level's representation
- `nq`, `nv`, `nu`: MuJoCo's positions, velocities and controls
- `n`, `m`: any vector, such as an embedding

Other names, such as `keyframe`, belong to the file that has them.
"""

from typing import TYPE_CHECKING

import jax
import numpy as np

if TYPE_CHECKING:
    from jax import Array as Array
else:  # JAX's functions take NumPy's arrays too
    Array = jax.Array | np.ndarray
