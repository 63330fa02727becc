import numpy as np

from pigbench.report import profiles
from pigbench.report.scoring import Scoring


def test_lines_by_hand(make_results):
    results = make_results(
        {
            ("qrl", "cube-single"): [{1: [40]}, {1: [60]}],
            ("qrl", "cube-double"): [{1: [0]}, {1: [60]}],
            ("mine", "cube-single"): [{1: [100]}, {1: [100]}],
            ("mine", "cube-double"): [{1: [100]}, {1: [100]}],
        }
    )
    (panel,) = profiles.draw(results, ("cube-single", "mine"), Scoring()).axes
    assert panel.get_title() == "cube-single, cube-double"
    mine, qrl = (dict(line.get_xydata()) for line in panel.lines)
    assert (mine[0], mine[99.5], mine[100]) == (100, 100, 0)
    assert [qrl[x] for x in (0, 39.5, 40, 59.5, 60)] == [75, 75, 50, 50, 0]
    band = panel.collections[1].get_paths()[0].vertices
    # Below 40 a draw of the second environment may be 0 twice or 60 twice, 1/4 each.
    heights = band[np.isclose(band[:, 0], 20), 1]
    assert (heights.min(), heights.max()) == (50, 100)
