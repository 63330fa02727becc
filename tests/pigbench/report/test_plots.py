import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pigbench.errors import UserError
from pigbench.report import canvas, plots, stats, styles
from pigbench.report.scoring import Scoring


@pytest.fixture
def results(tmp_path, make_run):
    return stats.read_results(
        make_run(
            tmp_path / f"{method}-{environment}-{seed}",
            {0: [[0, 0]], 100: [[1, seed]], 200: [[1, 1]]},
            method=method,
            environment=environment,
            seed=seed,
            agent={"low_level_representation": "full"},
        )
        for method in ("gcivl", "mine")
        for environment in ("cube-single", "cube-double")
        for seed in (0, 1)
    )


@pytest.mark.parametrize("kind", plots.KINDS)
def test_every_kind_shows_every_method_in_its_colour(tmp_path, results, kind):
    plots.plot(results, tmp_path / "picture.png", kind=kind)
    picture = Image.open(tmp_path / "picture.png").convert("RGB")
    assert picture.width > 900
    assert picture.height > 400
    pixels = np.asarray(picture)
    for method in ("gcivl", "mine"):
        assert (pixels == styles_rgb(method)).all(axis=-1).sum() > 200


def styles_rgb(method):
    color = styles.styles(["gcivl", "mine"])[method].color
    return np.array([int(color[start : start + 2], 16) for start in (1, 3, 5)])


@pytest.mark.parametrize("kind", plots.KINDS)
def test_every_kind_says_what_methods_were_told_of_goals(tmp_path, make_run, kind):
    both = {"low_level_representation": "full"}, {"low_level_representation": "joints_contacts"}
    results = stats.read_results(
        make_run(tmp_path / method / goals, {0: [[0]]}, method=method, variant=goals, agent=agent)
        for method, agent in zip(("sharsa", "mine"), both, strict=True)
        for goals, agent in {"state": agent, "cubes": agent | {"goals": "cubes"}}.items()
    )
    figure = plots.KINDS[kind].draw(results, (), Scoring())
    said = "goals: cubes (mine (cubes), sharsa (cubes)), state (mine (state), sharsa (state))"
    assert figure.get_suptitle().replace("\n", " ") == said
    usual = plots.KINDS[kind].draw(results[::2], (), Scoring())
    assert usual.get_suptitle() == ""
    assert figure.get_figheight() > usual.get_figheight()


@pytest.mark.parametrize("kind", plots.KINDS)
def test_every_kind_says_what_evaluations_do_not_share(tmp_path, make_run, kind):
    low = {"agent": {"low_level_representation": "full"}}
    results = stats.read_results(
        [
            make_run(tmp_path / "a", {100: [[1, 0]]}, method="sharsa", **low),
            make_run(tmp_path / "b", {100: [[1]], 200: [[1]]}, method="mine", **low),
        ]
    )
    said = plots.KINDS[kind].draw(results, (), Scoring()).get_suptitle().replace("\n", " ")
    steps = "unequal last step on cube-single: 200 (mine); 100 (sharsa); "
    shown = kind in ("curves", "columns")  # the last step itself
    counts = "unequal episodes per task on cube-single: 1 (mine); 2 (sharsa)"
    assert said == ("" if shown else steps) + counts
    first = plots.KINDS[kind].draw(results, (), Scoring(first_episodes=1)).get_suptitle()
    assert first.replace("\n", " ") == ("" if shown else steps.removesuffix("; "))


@pytest.mark.parametrize("kind", plots.KINDS)
@pytest.mark.parametrize(
    ("name", "magic"), [("a.pdf", b"%PDF"), ("a.svg", b"<?xml"), ("a.PNG", b"\x89PNG")]
)
def test_the_extension_tells_the_format_and_bytes_repeat(tmp_path, results, kind, name, magic):
    plots.plot(results, tmp_path / name, kind=kind)
    first = (tmp_path / name).read_bytes()
    plots.plot(results[::-1], tmp_path / name, kind=kind)
    assert first.startswith(magic)
    assert (tmp_path / name).read_bytes() == first


@pytest.mark.parametrize(
    ("values", "labels"),
    [((20_000, 140_000), ["20k", "50k", "100k"]), ((0.002, 300), ["0.01", "1", "100"])],
)
def test_logarithmic_axes_have_plain_numbers(tmp_path, values, labels):
    with canvas.look():
        figure, panels = canvas.grid(1, 1, panel=(3, 2), legend=[])
        panels[0, 0].plot(values, values)
        canvas.log_axis(panels[0, 0], "x")
        canvas.log_axis(panels[0, 0], "y")
        canvas.save(figure, tmp_path / "a.svg")
    texts = re.findall("<!-- (.*) -->", (tmp_path / "a.svg").read_text())
    assert not any("$" in text for text in texts)
    assert all(texts.count(label) == 2 for label in labels)


OWN_LOG = re.compile(r"""scale["']?\s*[(=:,]\s*["'](sym)?log|scale\b.*["']log["']|loglog|semilog""")


@pytest.mark.parametrize(
    "line",
    [
        'panel.set_xscale("log", base=2)',
        'panel.set(xscale="log", ylim=(1, 2))',
        'panel.set(**{f"{name}scale": "log"})',
        'panel.set_yscale(\n    "symlog")',
        "panel.semilogy(x, y)",
        "panel.loglog(x, y)",
    ],
)
def test_logarithmic_axes_are_found_however_they_are_set(line):
    assert OWN_LOG.search(line)


def test_no_figure_has_a_logarithmic_axis_of_its_own():
    code = Path(canvas.__file__).parents[1]
    own = {path.name for path in code.rglob("*.py") if OWN_LOG.search(path.read_text())}
    assert own == {"canvas.py", "scaling.py"}  # the one for all, and one whose labels are the sizes


def test_a_figure_is_drawn_if_results_can_fill_it(make_results):
    flat = make_results({("gcivl", "one"): [{1: [50]}], ("qrl", "one"): [{1: [50]}]})
    assert plots.fillable(flat) == ["curves", "bars", "box", "profile", "milestones"]
    low = {"agent": {"low_level_representation": "full"}}
    apart = make_results({("sharsa", "two"): [{1: [50]}]}, **low)
    assert plots.fillable([*flat, *apart]) == ["curves", "bars", "columns", "milestones"]
    for kind, few in {"columns": flat, "box": [*flat, *apart], "profile": [*flat, *apart]}.items():
        with pytest.raises(UserError):
            plots.KINDS[kind].draw(few, (), Scoring())


def test_the_folder_is_made(tmp_path, results):
    plots.plot(results, tmp_path / "new" / "folder" / "curves.png")
    assert (tmp_path / "new" / "folder" / "curves.png").exists()


def test_unknown_names_offer_the_nearest(tmp_path, results):
    with pytest.raises(UserError, match=r"unknown picture format 'pgn'.*did you mean 'pn?g"):
        plots.plot(results, tmp_path / "curves.pgn")
    with pytest.raises(UserError, match="unknown kind of picture 'boxes': did you mean 'box'"):
        plots.plot(results, tmp_path / "boxes.png", kind="boxes")
