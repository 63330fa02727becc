import itertools

import pytest

from pigbench.support.grouping import grouped, repeated


def test_groups_are_those_of_a_stable_sort_in_order_of_appearance():
    words = ["pear", "fig", "kiwi", "apple", "plum", "nut"]
    by_sorting = itertools.groupby(sorted(words, key=len), key=len)
    groups = grouped(words, len)
    assert groups == {length: list(group) for length, group in by_sorting}
    assert list(groups) == [4, 3, 5]


@pytest.mark.parametrize(
    ("items", "expected"), [("abba", "a"), ("abcb", "b"), ("abc", None), ("", None)]
)
def test_the_first_item_that_occurs_again(items, expected):
    assert repeated(items) == expected
