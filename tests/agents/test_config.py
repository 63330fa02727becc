import pytest

from pigbench.agents import TargetConfig
from pigbench.errors import UserError


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("learning_rate", 0.0),
        ("learning_rate", float("nan")),
        ("batch_size", 0),
        ("discount", 1.0),
        ("target_rate", 1.5),
        ("actor_hidden_sizes", (256, 0)),
        ("value_hidden_sizes", (256, 0)),
    ],
)
def test_a_value_out_of_range_is_named(field, value):
    with pytest.raises(UserError, match=f"^{field} is .*: it must be "):
        TargetConfig(**{field: value})
