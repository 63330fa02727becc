import pytest

from pigbench import cli
from pigbench.agents import AWRExtraction, EikonalRegularizer, HJBConstraint, HJBRegularizer
from pigbench.errors import UserError


def agent(arguments: str):
    name, *more = arguments.split()
    return cli.parse(["train", name, "--data", "d", "--out", "o", *more]).agent


@pytest.mark.parametrize(
    ("arguments", "option", "expected"),
    [
        (
            "hjb-gcivl --agent.regularizer.weight 0.1 --agent.regularizer.direction raw",
            "regularizer",
            HJBRegularizer(weight=0.1, direction="raw"),
        ),
        (
            "gcivl --agent.regularizer.kind eikonal --agent.regularizer.speed 2",
            "regularizer",
            EikonalRegularizer(speed=2.0),
        ),
        (
            "hjb-qrl --agent.constraint.kind hjb --agent.constraint.margin 0.2",
            "constraint",
            HJBConstraint(margin=0.2),
        ),
        (
            "qrl --agent.actor.temperature 5 --agent.actor.kind=awr",
            "actor",
            AWRExtraction(temperature=5.0),
        ),
    ],
)
def test_an_option_has_the_constants_of_its_kind(arguments, option, expected):
    assert getattr(agent(arguments), option) == expected


def test_the_method_comes_first_else_its_hyperparameters_would_be_anothers():
    with pytest.raises(UserError, match="METHOD must come first: pigbench train METHOD --data"):
        cli.parse(["train", "--data", "d", "hjb-gcivl", "--out", "o"])


@pytest.mark.parametrize(
    "option",
    ["--agent.low.learning-rate 3e-4", "--agent.low.discount=0.999", "--agent.low.target_rate 0.1"],
)
def test_what_a_hierarchy_decides_is_neither_an_option_nor_recorded(option):
    name = option.split()[0].split("=")[0].removeprefix("--agent.").replace("-", "_")
    with pytest.raises(UserError, match=f"^{name} has no effect: leave it out"):
        agent(f"h-flow-gcivl --preset cpu {option}")
    record = agent("h-flow-gcivl --preset cpu").record()
    assert name.split(".")[1] in record
    assert name.split(".")[1] not in record["low"]
    assert record["low"]["expectile"] == 0.9


def test_goals_may_be_asked_for_in_short():
    assert agent("gcivl --goals cubes").goals == agent("gcivl --agent.goals cubes").goals == "cubes"
    assert agent("gcivl --goals cubes --agent.goals cubes").goals == "cubes"


def test_kinds_are_chosen_at_each_level():
    low = agent("h-flow-gcivl --agent.low.regularizer.kind hjb --agent.low.expectile 0.7").low
    assert (low.regularizer, low.expectile) == (HJBRegularizer(), 0.7)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ("gcivl --agent.regularizer.weight 0.1", "Unrecognized options"),
        ("hjb-gcivl --agent.regularizer.speed 2", "Unrecognized options"),
        ("qrl --agent.actor.kind awr --agent.actor.bc-weight 1", "Unrecognized options"),
        ("gcivl --agent.regularizer.kind eikonel", "unknown regularizer 'eikonel': did you mean"),
        ("gcivl --agent.regularizer.kind", "kind"),
        ("gcivl --agent.learning-rate 1e400", "learning_rate is inf: it must be a finite number"),
        ("gcivl --agent.temperature nan", "temperature is nan: it must be a finite number"),
    ],
)
def test_constants_of_another_kind_are_refused(arguments, says):
    with pytest.raises(UserError, match=says):
        agent(arguments)
