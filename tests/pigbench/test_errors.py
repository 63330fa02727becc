"""The checks that raise a user's error."""

import dataclasses
import math

import pytest

from pigbench.errors import UserError, lookup_own, require, require_left_out


@dataclasses.dataclass(frozen=True)
class Config:
    rate: float


def test_a_value_must_satisfy_its_rule_and_be_finite():
    require(Config(0.5), lambda x: x > 0, "positive", "rate")
    with pytest.raises(UserError, match=r"rate is -1\.0: it must be positive"):
        require(Config(-1.0), lambda x: x > 0, "positive", "rate")
    for value in (math.inf, -math.inf, math.nan):
        with pytest.raises(UserError, match=f"rate is {value}: it must be a finite number"):
            require(Config(value), lambda x: True, "anything", "rate")


@dataclasses.dataclass(frozen=True)
class Options:
    number: int | None = None
    flag: bool = False
    several: tuple[int, ...] = ()


@pytest.mark.parametrize("given", [{"number": 0}, {"flag": True}, {"several": (0,)}])
def test_an_option_without_effect_must_be_left_out(given):
    fields = "number", "flag", "several"
    require_left_out(Options(), "here", *fields)
    with pytest.raises(UserError, match=f"{next(iter(given))} has no effect here: leave it out"):
        require_left_out(Options(**given), "here", *fields)


def test_what_a_file_may_add_is_asked_for():
    assert lookup_own("method", {"a": 1}, "a") == 1
    with pytest.raises(UserError, match=r"unknown method 'b': known are a \(.*--plugin FILE\)"):
        lookup_own("method", {"a": 1}, "b")
