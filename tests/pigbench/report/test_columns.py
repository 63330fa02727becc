import numpy as np
import pytest

from pigbench.errors import UserError
from pigbench.report import columns
from pigbench.report.scoring import Scoring

FULL = {"variant": "full", "agent": {"low_level_representation": "full"}}
WIDE = {"variant": "wide", "agent": {"low_level_representation": "full", "hidden": [512]}}
JOINTS = {"variant": "joints", "agent": {"low_level_representation": "joints_contacts"}}


def lines(panel):
    return [line.get_xydata().tolist() for line in panel.lines]


def test_columns_by_hand(make_results):
    cell = "cube-single"
    results = [
        *make_results(
            {
                ("sharsa", cell): [{0: [0], 100: [40]}, {0: [0], 100: [60]}],
                ("h-flow-qrl", cell): [{0: [0], 100: [20]}, {0: [20], 100: [40]}],
            },
            **FULL,
        ),
        # The second seed of one method alone does not count in the average.
        *make_results(
            {
                ("sharsa", cell): [{0: [0], 100: [80]}],
                ("h-flow-qrl", cell): [{0: [0], 100: [100]}, {0: [0], 100: [0]}],
            },
            **JOINTS,
        ),
        *make_results({("gcivl", cell): [{0: [90], 100: [90]}]}),
    ]
    figure = columns.draw(results, ("sharsa", "h-flow-qrl"), Scoring())
    full, joints, average = figure.axes
    assert [panel.get_title() for panel in figure.axes] == [
        "full state",
        "joints and contacts",
        "average over methods",
    ]
    assert sorted(lines(full)) == [[[0, 0], [100, 50]], [[0, 10], [100, 30]]]
    assert sorted(lines(joints)) == [[[0, 0], [100, 50]], [[0, 0], [100, 80]]]
    # Full state: the seeds' averages are 0, 30 and 10, 50.
    assert lines(average) == [[[0, 5], [100, 40]], [[0, 0], [100, 90]]]
    heights = average.collections[0].get_paths()[0].vertices[:, 1]
    np.testing.assert_allclose(heights.max(), 40 + np.std([30, 50], ddof=1))


def test_methods_need_a_seed_in_common(make_results):
    results = make_results(
        {("sharsa", "e"): [{0: [0]}], ("h-flow-qrl", "e"): [{0: [0]}, {0: [0]}]}, **FULL
    )
    with pytest.raises(UserError, match="no seed in common"):
        columns.draw([results[0], results[2]], (), Scoring())


def test_flat_methods_have_no_columns(make_results):
    results = make_results({("qrl", "e"): [{0: [0]}]}, agent={})
    with pytest.raises(UserError, match="give runs of hierarchies"):
        columns.draw(results, (), Scoring())


def titles(figure):
    return [panel.get_title().replace("\n", " ") for panel in figure.axes]


def names(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_average_is_over_the_methods_that_all_representations_share(make_results):
    both = {("sharsa", "e"): [{0: [40]}], ("h-flow-qrl", "e"): [{0: [0]}]}
    results = [
        *make_results(both | {("h-flow-gcivl", "e"): [{0: [90]}]}, **FULL),
        *make_results({("sharsa", "e"): [{0: [80]}], ("h-flow-qrl", "e"): [{0: [20]}]}, **JOINTS),
    ]
    figure = columns.draw(results, ("sharsa", "h-flow-qrl"), Scoring())
    assert lines(figure.axes[-1]) == [[[0, 20]], [[0, 50]]]
    assert titles(figure)[-1] == "average over sharsa, h-flow-qrl"
    assert len(lines(figure.axes[0])) == 3


def test_each_environment_has_an_average_of_its_own(make_results):
    all_have = {("sharsa", "one"): [{0: [40]}], ("sharsa", "two"): [{0: [10]}]}
    more = {("h-flow-qrl", "one"): [{0: [60]}]}
    results = [*make_results(all_have | more, **FULL), *make_results(all_have | more, **JOINTS)]
    figure = columns.draw(results, ("sharsa", "h-flow-qrl"), Scoring())
    assert lines(figure.axes[2]) == [[[0, 50]]] * 2
    assert lines(figure.axes[5]) == [[[0, 10]]] * 2
    assert titles(figure)[2::3] == ["average over methods", "average over sharsa"]


def test_variants_that_see_the_same_are_all_drawn(make_results):
    cell = {("sharsa", "e"): [{0: [40]}]}
    results = [
        *make_results(cell, **FULL),
        *make_results({("sharsa", "e"): [{0: [70]}]}, **WIDE),
        *make_results({("sharsa", "e"): [{0: [90]}]}, **JOINTS),
    ]
    figure = columns.draw(results, (), Scoring())
    assert [lines(panel) for panel in figure.axes] == [[[[0, 40]], [[0, 70]]], [[[0, 90]]], []]
    assert titles(figure)[-1] == "no average: no method has all representations"
    assert names(figure) == ["sharsa (full)", "sharsa (joints)", "sharsa (wide)"]
