"""Arrays, and what the axes in their types are: shapes are checked in tests.

In one call, axes of the same name are as long as each other.

- `batch`: examples; `*batch` stands for any leading axes, or none
- `member`: members of an ensemble; `*member` also for none
- `candidate`: samples, of which one is chosen
- `observation`: an observation, or a state as an agent sees it
- `goal`: a goal as networks see it (`Agent.as_goals`)
- `action`: an action, or another choice made in a state, such as a subgoal
- `x`: a state or subgoal in a low level's representation
- `n`, `m`: any vector, such as an embedding
"""

from typing import TYPE_CHECKING

import jax
import numpy as np

if TYPE_CHECKING:
    from jax import Array as Array
else:  # JAX's functions take NumPy's arrays too
    Array = jax.Array | np.ndarray
