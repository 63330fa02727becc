import pytest

from pigbench.errors import UserError
from pigbench.support.compare import first_difference, require_same, split


def test_equal_as_json_is_equal():
    stored = {"seed": 1, "agent": {"hidden": [2, 3]}}
    assert first_difference(stored, {"agent": {"hidden": (2, 3)}, "seed": 1}) is None


@pytest.mark.parametrize(
    ("second", "expected"),
    [
        ({"a": 1, "b": {"c": 3, "d": 4}}, ("b.c", 2, 3)),
        ({"a": 1, "b": {"d": 4}}, ("b.c", 2, "absent")),
        ({"a": 1, "b": {"c": 2, "d": 4}, "e": None}, ("e", "absent", None)),
    ],
)
def test_the_first_difference_is_named_with_dots(second, expected):
    assert first_difference({"a": 1, "b": {"c": 2, "d": 4}}, second) == expected


def test_configurations_split_into_what_they_share_and_what_not():
    shared, differing = split(
        [{"a": 1, "b": {"c": (2,), "d": 4}}, {"a": 1, "b": {"c": [2], "d": 5}, "e": None}]
    )
    assert shared == {"a": 1, "b.c": [2]}
    assert differing == {"b.d": [4, 5], "e": [None, None]}
    assert split([]) == ({}, {})


def test_the_error_is_one_line_with_both_values():
    with pytest.raises(UserError) as error:
        require_same("runs/x", {"agent": {"discount": 0.99}}, {"agent": {"discount": 0.999}})
    message = str(error.value)
    assert message.startswith("runs/x was made with another configuration: agent.discount is 0.99")
    assert "0.999 now" in message
    assert "\n" not in message
