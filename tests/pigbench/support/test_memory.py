import pytest

from pigbench.errors import UserError
from pigbench.support import memory


def test_more_simulations_than_the_memory_holds_are_refused():
    memory.require(10)
    with pytest.raises(UserError, match=r"1,000,000,000 simulations .* take 4,096\.0 GB at least"):
        memory.require(10**9)
