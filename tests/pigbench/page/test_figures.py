"""Figures, read back from the JSON that the page's script is given."""

from collections.abc import Iterator
from typing import Any

import pytest

from pigbench.page import figures
from pigbench.page.looks import looks
from pigbench.report import stats
from pigbench.report.bootstrap import Interval
from pigbench.report.stats import Estimate
from pigbench.runs.run import read_run

LOOKS = looks(["gcivl", "hjb-gcivl", "mine"])


def models(value: Any) -> Iterator[dict[str, Any]]:
    """All models in a figure's JSON."""
    if isinstance(value, dict):
        if value.get("type") == "object":
            yield value
        for inner in value.values():
            yield from models(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from models(inner)


def named(json: Any, kind: str) -> list[dict[str, Any]]:
    return [model["attributes"] for model in models(json) if model["name"] == kind]


def sources(json: Any) -> list[dict[str, Any]]:
    return [dict(source["data"]["entries"]) for source in named(json, "ColumnDataSource")]


def results(folders):
    return stats.read_results(map(read_run, folders))


def test_a_curve_is_the_mean_in_its_band(runs):
    gcivl, (unfinished,) = results(runs[:2]), results(runs[2:3])
    drawn = figures.curves({"gcivl": gcivl}, {"hjb-gcivl": [unfinished]}, LOOKS)
    curve, band, alone = sources(drawn)[0], named(drawn, "VArea"), sources(drawn)[-1]
    assert (curve["step"], curve["value"]) == ([0, 200], [0.0, 75.0])
    deviation = 50 / 2**0.5  # of 50 and 100
    assert curve["low"] == pytest.approx([0, 75 - deviation])
    assert curve["high"] == pytest.approx([0, 75 + deviation])
    assert curve["shown"][-1] == "75.0 ± 35.4"
    assert len([one for one in band if one["fill_color"] == LOOKS["gcivl"].shade.light]) == 1
    assert (alone["value"], alone["method"][0]) == ([0.0, 50.0], "hjb-gcivl, seed 0, unfinished")


def test_bars_stand_by_method_in_their_groups():
    groups = {
        "gcivl": {"touched": Estimate(80.0, 5.0, Interval(75.0, 85.0), 3), "held": None},
        "mine": {"touched": Estimate(20.0), "held": Estimate(0.0)},
    }
    drawn = figures.bars(groups, "episodes (%)", LOOKS)
    (places,) = (one["factors"] for one in named(drawn, "FactorRange"))
    assert [list(place) for place in places] == [
        ["touched", "gcivl"],
        ["touched", "mine"],
        ["held", "gcivl"],
        ["held", "mine"],
    ]
    bars = [source for source in sources(drawn) if "group" in source]
    assert [source["value"] for source in bars] == [[80.0], [20.0, 0.0]]
    assert (bars[0]["low"], bars[0]["high"], bars[0]["seeds"]) == ([75.0], [85.0], [3])
    assert bars[0]["interval"] == ["75.0 to 85.0 (95 %)"]
    assert bars[1]["interval"] == ["–", "–"]
    assert len(named(drawn, "Whisker")) == 1  # a single seed has no deviation
    dashes = [source["place"] for source in sources(drawn) if "text" in source]
    assert [[list(place) for place in own] for own in dashes] == [[["held", "gcivl"]], []]


def test_what_is_of_a_method_can_be_hidden_by_its_name():
    drawn = figures.bars({"mine": {"touched": Estimate(20.0, 1.0)}}, "episodes (%)", LOOKS)
    kinds = {
        model["name"]
        for model in models(drawn)
        if model.get("attributes", {}).get("name") == "mine"
    }
    assert kinds == {"GlyphRenderer", "Whisker"}
