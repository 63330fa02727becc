import numpy as np
import pytest
from matplotlib.colors import to_hex

from pigbench.errors import UserError
from pigbench.report import boxes
from pigbench.report.scoring import Scoring

FULL = {"variant": "full", "agent": {"low_level_representation": "full"}}
JOINTS = {"variant": "joints", "agent": {"low_level_representation": "joints_contacts"}}
WHITE = "#ffffff"
STRONG = {"variant": "strong", "agent": {"margin": 2.0}}


def dots(panel, color):
    return [
        line.get_ydata().tolist()
        for line in panel.lines
        if line.get_marker() == "o" and line.get_color() == color
    ]


def ticks(panel):
    return [label.get_text() for label in panel.get_xticklabels()]


def test_a_dot_an_environment_and_the_mean_in_white(make_results):
    environments = ("one", "two", "three")
    rates = {
        ("gcivl", "one"): [{0: [0], 1: [10]}, {0: [0], 1: [30]}],
        ("gcivl", "two"): [{0: [90], 1: [40]}, {0: [90], 1: [40]}],
        ("gcivl", "three"): [{0: [0], 1: [90]}, {0: [0], 1: [90]}],
        ("qrl", "one"): [{0: [0], 1: [70]}],
        ("qrl", "two"): [{0: [0], 1: [10]}],
        ("qrl", "three"): [{0: [0], 1: [10]}],
    }
    (panel,) = boxes.draw(make_results(rates), ("gcivl", *environments), Scoring("best")).axes
    assert [sorted(values) for values in dots(panel, "#000000")] == [[20, 90, 90], [10, 10, 70]]
    np.testing.assert_allclose(dots(panel, WHITE), [[200 / 3], [30]])
    assert ticks(panel) == ["gcivl", "qrl"]
    title = panel.get_title().replace("\n", " ")
    assert title == "best checkpoint of the mean over seeds, over one, two, three"


def test_boxes_are_over_environments_that_all_methods_have(make_results):
    rates = {
        ("gcivl", "one"): [{1: [80]}],
        ("gcivl", "two"): [{1: [0]}],
        ("qrl", "one"): [{1: [70]}],
    }
    (panel,) = boxes.draw(make_results(rates), (), Scoring()).axes
    assert dots(panel, "#000000") == dots(panel, WHITE) == [[80], [70]]
    assert panel.get_title() == "last evaluation, over one"
    apart = {("gcivl", "two"): [{1: [0]}], ("qrl", "one"): [{1: [70]}]}
    with pytest.raises(UserError, match="no environment has runs of all methods: gcivl, qrl"):
        boxes.draw(make_results(apart), (), Scoring())


def test_representations_of_a_method_share_a_name_and_differ_in_filling(make_results):
    cell = {("sharsa", "e"): [{1: [50]}]}
    results = [*make_results(cell, **JOINTS), *make_results(cell, **FULL)]
    results += make_results(cell, agent={"low_level_representation": "proprio"})
    figure = boxes.draw(results, (), Scoring())
    (panel,) = figure.axes
    assert ticks(panel) == ["sharsa"]
    faces = [to_hex(box.get_facecolor()) for box in panel.patches]
    assert faces == sorted(faces, reverse=True)  # from left to right: ever less white
    assert faces[0] == WHITE
    assert len(set(faces)) == 3
    assert [dots(panel, face) for face in faces] == [[[50]]] * 3
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "an environment",
        "mean over environments",
        "low level: full state",
        "low level: joints and contacts",
        "low level: proprioception",
    ]


def test_other_variants_have_their_own_names(make_results):
    cell = {("qrl", "e"): [{1: [50]}]}
    results = [*make_results(cell), *make_results(cell, **STRONG)]
    (panel,) = boxes.draw(results, (), Scoring()).axes
    assert ticks(panel) == ["qrl", "qrl (strong)"]
