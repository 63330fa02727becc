import numpy as np

from pigbench.report import curves
from pigbench.report.scoring import Scoring


def test_lines_and_bands_by_hand(make_results):
    results = make_results(
        {
            ("qrl", "cube-single"): [{0: [0], 100: [40]}, {0: [0], 100: [60]}],
            ("mine", "cube-double"): [{0: [10], 100: [70]}],
            ("mine", "cube-single"): [{50: [30]}],
        }
    )
    figure = curves.draw(results, ("mine", "cube-double"), Scoring())
    double, single = figure.axes
    assert [panel.get_title() for panel in figure.axes] == ["cube-double", "cube-single"]
    np.testing.assert_array_equal(double.lines[0].get_xydata(), [[0, 10], [100, 70]])
    mine, qrl = single.lines
    np.testing.assert_array_equal(mine.get_xydata(), [[50, 30]])
    np.testing.assert_array_equal(qrl.get_xydata(), [[0, 0], [100, 50]])
    heights = single.collections[1].get_paths()[0].vertices[:, 1]
    np.testing.assert_allclose([heights.min(), heights.max()], [0, 50 + np.sqrt(200)])
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["mine", "qrl"]


def test_many_environments_stand_in_rows(make_results):
    results = make_results({("qrl", f"env-{number}"): [{0: [0]}] for number in range(4)})
    panels = curves.draw(results, (), Scoring()).axes
    assert [panel.axison for panel in panels] == [True] * 4 + [False] * 2
