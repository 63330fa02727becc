import pytest

from pigbench.agents.stored import upgraded

CONSTANTS = {"weight": 1.0, "speed": 1.0, "epsilon": 1e-6, "direction": "own"}
"""What all kinds of regularisers had, with the defaults."""


@pytest.mark.parametrize(
    ("kind", "fields"),
    [("none", {}), ("eikonal", {"weight", "speed"}), ("hjb", {"weight", "epsilon", "direction"})],
)
def test_an_option_has_the_fields_of_its_kind_alone(kind, fields):
    old = {"discount": 0.9, "regularizer": {"kind": kind, **CONSTANTS}}
    new = {"kind": kind, **{name: CONSTANTS[name] for name in fields}}
    assert upgraded(old) == {"discount": 0.9, "regularizer": new}
    assert upgraded({"low": old})["low"]["regularizer"] == new
    assert upgraded(upgraded(old)) == upgraded(old)


def test_a_value_that_is_not_the_default_is_kept():
    odd = {"kind": "hjb", **CONSTANTS, "direction": "raw", "speed": 2.0}
    kept = {"weight": 1.0, "epsilon": 1e-6, "direction": "raw", "speed": 2.0}
    assert upgraded({"regularizer": odd}) == {"regularizer": {"kind": "hjb", **kept}}


@pytest.mark.parametrize(
    ("kind", "constant"), [("awr", {"temperature": 5.0}), ("ddpg+bc", {"bc_weight": 0.7})]
)
def test_the_kind_of_an_actor_has_its_constants(kind, constant):
    old = {"actor": kind, "bc_weight": 0.3, "temperature": 10.0, "discount": 0.9} | constant
    assert upgraded(old) == {"discount": 0.9, "actor": {"kind": kind} | constant}


def test_the_fields_of_other_agents_are_left_alone():
    others = {"temperature": 10.0, "bc_weight": 0.3, "goals": {"current": 0.2}, "actor": "mine"}
    assert upgraded(others) == others
