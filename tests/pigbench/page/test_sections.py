from pigbench.page.looks import looks
from pigbench.page.sections import sections
from pigbench.report import stats
from pigbench.report.scoring import Scoring

CUBES = {"agent": {"goals": "cubes"}}


def test_captions_of_figures_say_what_methods_do_not_share(tmp_path, make_run):
    done = stats.read_results(
        [
            make_run(tmp_path / "a", {1: [[1, 0]]}),
            make_run(tmp_path / "b", {1: [[1]], 2: [[1]]}, method="qrl", **CUBES),
        ]
    )
    unfinished = stats.read_results([make_run(tmp_path / "c", {1: [[1]]}, method="crl", **CUBES)])
    shown = looks(["gcivl", "qrl", "crl"])
    (section,) = sections(done, unfinished, (), Scoring(first_episodes=5), shown)
    curves, *bars = [figure.caption for figure in section.figures]
    assert curves == (
        "Mean over seeds, in a band of one standard deviation to each side; goals: cubes (crl, "
        "qrl), state (gcivl); unequal episodes per task on cube-single: 1 (crl, qrl); 2 (gcivl). "
        "Faint: unfinished runs, one by one."
    )
    assert bars == 2 * [
        "Last evaluation, 1 and 2 episodes per task; whiskers: one standard deviation over seeds; "
        "goals: cubes (qrl), state (gcivl); unequal last step on cube-single: 1 (gcivl); 2 (qrl); "
        "unequal episodes per task on cube-single: 2 (gcivl); 1 (qrl)."
    ]
