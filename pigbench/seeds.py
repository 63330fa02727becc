"""Seeds, and the random keys made from them."""

from typing import TYPE_CHECKING, Annotated

import pydantic
from tyro.constructors import PrimitiveConstructorSpec

from pigbench.errors import UserError

if TYPE_CHECKING:
    import jax

LARGEST = 2**32 - 1
"""JAX would use only the last 32 bits of a larger seed."""


def check(seed: int) -> int:
    """Return the seed. Raises UserError unless it is from 0 to `LARGEST`."""
    if not 0 <= seed <= LARGEST:
        raise UserError(f"seed is {seed}: it must be from 0 to {LARGEST}")
    return seed


IMPLEMENTATION = "threefry2x32"
"""JAX's implementation of random keys here, whatever its default is."""


def key(seed: int) -> "jax.Array":
    """The random key of a seed. Raises UserError like `check`."""
    import jax  # here, because some commands do without it

    return jax.random.key(check(seed), impl=IMPLEMENTATION)


_OPTION = PrimitiveConstructorSpec(
    nargs=1,
    metavar="INT",
    instance_from_str=lambda words: check(int(words[0])),
    is_instance=lambda value: value is None or isinstance(value, int),
    str_from_instance=lambda seed: [str(seed)],
)

Seed = Annotated[int, pydantic.AfterValidator(check), _OPTION]
"""A seed as a field: command lines and suite files with an invalid one are rejected."""

OptionalSeed = Annotated[int | None, _OPTION]
"""A seed as a field of a command, None where it is not given."""
