import itertools

import numpy as np
import pytest

from pigbench.report import bars, stats
from pigbench.report.scoring import Scoring


def test_bars_by_hand(make_results):
    results = make_results(
        {
            ("qrl", "cube-single"): [{0: [0, 0], 100: [40, 100]}, {0: [0, 90], 100: [60, 100]}],
            ("mine", "cube-single"): [{0: [0, 0], 100: [10, 30]}],
            ("mine", "cube-double"): [{0: [0, 0], 100: [20, 70]}],
        }
    )
    figure = bars.draw(results, ("cube-single", "qrl"), Scoring())
    single, double = figure.axes
    assert single.get_title() == "cube-single, last evaluation"
    assert [label.get_text() for label in single.get_xticklabels()] == ["task1", "task2"]
    heights = [[bar.get_height() for bar in group.patches] for group in _bars(single)]
    np.testing.assert_allclose(heights, [[50, 100], [10, 30]])
    assert [[bar.get_height() for bar in group.patches] for group in _bars(double)] == [[20, 70]]
    whisker = single.collections[0].get_segments()[0][:, 1]
    np.testing.assert_allclose(whisker, [50 - np.sqrt(200), 50 + np.sqrt(200)])


def test_bars_of_a_panel_do_not_overlap(make_results):
    methods = [f"method-{number}" for number in range(7)]
    results = make_results({(method, "e"): [{1: [50, 50, 50]}] for method in methods})
    (panel,) = bars.draw(results, (), Scoring()).axes
    edges = sorted((bar.get_x(), bar.get_x() + bar.get_width()) for bar in panel.patches)
    assert len(edges) == 3 * 7
    gaps = [begin - end for (_, end), (begin, _) in itertools.pairwise(edges)]
    assert min(gaps) > 0
    # Ticks are below the middle of their bars.
    for tick, group in zip(panel.get_xticks(), np.reshape(edges, (3, 14)), strict=True):
        assert tick == pytest.approx((group[0] + group[-1]) / 2)


def _bars(panel):
    return [group for group in panel.containers if hasattr(group, "patches")]


def test_milestones_by_hand_with_a_dash_for_what_is_not_known(tmp_path, make_run):
    some = {"touched": True, "held": True, "lifted": False}
    results = stats.read_results(
        [
            make_run(tmp_path / "a", {1: [[0, 1]]}, method="new", more=some),
            make_run(tmp_path / "b", {1: [[1, 1]]}, method="old"),
        ]
    )
    (panel,) = bars.draw_milestones(results, (), Scoring()).axes
    stages = ["touched", "held", "lifted", "within 10 cm", "within 5 cm", "success"]
    assert [label.get_text() for label in panel.get_xticklabels()] == stages
    new, old = ([bar.get_height() for bar in group.patches] for group in _bars(panel))
    nan = np.nan
    np.testing.assert_array_equal(new, [100, 100, 0, nan, nan, 50])
    np.testing.assert_array_equal(old, [nan] * 5 + [100])
    dashes = {(text.get_text(), text.get_position()) for text in panel.texts}
    assert dashes == {("–", (9, 0)), ("–", (12, 0)), *(("–", (3 * n + 1, 0)) for n in range(5))}
