"""The choice of the next cube and its target, distributed as in OGBench's data collection."""

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, ArrayLike, Bool, Float, Int, PRNGKeyArray

from pigbench.envs import workspace
from pigbench.envs.cubes import CUBE_HALF_SIZE

ON_TOP_DISTANCE = 0.02  # metres in x and y within which a higher cube lies on a lower one
FIRST_STACKING = 0.5  # the probability for an episode's first target


@struct.dataclass
class Target:
    """A sub-task: move `cube` (an index) to `pos`, metres, and `yaw`, radians."""

    cube: Int[Array, ""]
    pos: Float[Array, "3"]
    yaw: Float[Array, ""]


def is_top(cubes: Float[Array, "cube 3"]) -> Bool[Array, "cube"]:
    """Which cubes have no cube on top, from their positions."""
    offset = cubes[None, :, :] - cubes[:, None, :]
    near = jnp.linalg.norm(offset[..., :2], axis=-1) < ON_TOP_DISTANCE
    return ~jnp.any(near & (offset[..., 2] > 0), axis=1)


def draw(
    key: PRNGKeyArray, cubes: Float[Array, "cube 3"], stacking: Float[ArrayLike, ""]
) -> Target:
    """A target for a top cube: on another top cube with probability `stacking`, else on the floor.

    `cubes` are their positions in metres.
    """
    # One call for all draws, because each call costs compile time.
    cube_unit, base_unit, stack_unit, yaw_unit, *xy_unit = jax.random.uniform(key, (6,))
    top = is_top(cubes)
    cube = _choose(cube_unit, top)
    others = top.at[cube].set(False)
    base = cubes[_choose(base_unit, others)]
    stack = jnp.any(others) & (stack_unit < stacking)
    on_floor = jnp.append(workspace.CUBE.point(jnp.stack(xy_unit)), CUBE_HALF_SIZE)
    on_cube = base.at[2].add(2 * CUBE_HALF_SIZE)
    return Target(cube=cube, pos=jnp.where(stack, on_cube, on_floor), yaw=2 * jnp.pi * yaw_unit)


def _choose(unit: Float[Array, ""], allowed: Bool[Array, "cube"]) -> Int[Array, ""]:
    """The index that `unit` in [0, 1) selects uniformly among those allowed; 0 if none is."""
    ranks = jnp.cumsum(allowed)
    return jnp.argmax(ranks > jnp.floor(unit * ranks[-1]))
