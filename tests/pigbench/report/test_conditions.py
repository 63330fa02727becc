import itertools

import pytest

from pigbench.report import stats
from pigbench.report.conditions import remarks

CUBES = {"agent": {"goals": "cubes"}}
SINGLE, DOUBLE = "cube-single", "cube-double"


@pytest.fixture
def told(tmp_path, make_run):
    """`told({(method, environment): changes})`: the remarks, the same in any order of runs."""

    def tell(changed, **options):
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        results = stats.read_results(
            make_run(
                folder / method / environment,
                {1: [[1]]},
                method=method,
                environment=environment,
                **changes,
            )
            for (method, environment), changes in changed.items()
        )
        (said,) = {tuple(remarks(some, **options)) for some in itertools.permutations(results)}
        return list(said)

    return tell


def test_what_is_usual_needs_no_saying(told):
    cells = {("gcivl", SINGLE): {}, ("qrl", DOUBLE): {}}
    assert told(cells) == []
    assert told(cells, always=["physics"]) == ["physics: exact"]


def test_what_is_unusual_is_said_once(told):
    changes = {"physics": "fast", "preset": "paper", **CUBES}
    cells = {("gcivl", SINGLE): changes, ("qrl", SINGLE): changes}
    assert told(cells) == ["physics: fast", "goals: cubes"]


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({("gcivl", SINGLE): CUBES, ("gcivl", DOUBLE): CUBES}, "cubes (gcivl), state (qrl)"),
        (
            {("gcivl", DOUBLE): CUBES, ("qrl", DOUBLE): CUBES},
            "cubes (cube-double), state (cube-single)",
        ),
        (
            {("gcivl", DOUBLE): CUBES},
            "cubes (gcivl on cube-double), state (gcivl on cube-single, qrl on cube-double, "
            "qrl on cube-single)",
        ),
    ],
)
def test_goals_are_those_of_methods_or_environments_or_both(told, changed, said):
    cells = {cell: {} for cell in itertools.product(("gcivl", "qrl"), (SINGLE, DOUBLE))}
    assert told(cells | changed) == [f"goals: {said}"]


def test_other_physics_and_presets_are_told(told):
    cells = {
        ("gcivl", SINGLE): {},
        ("qrl", SINGLE): {"preset": "paper"},
        ("gcivl", DOUBLE): {"physics": "fast"},
    }
    assert told(cells) == [
        "physics: exact (cube-single), fast (cube-double)",
        "preset: cpu (gcivl), paper (qrl)",
    ]


def test_other_data_are_told_within_an_environment(told):
    other, another = ({"dataset_digest": digit * 64} for digit in "12")
    assert told({("gcivl", SINGLE): {}, ("gcivl", DOUBLE): other}) == []
    cells = {("gcivl", SINGLE): other, ("crl", SINGLE): other, ("qrl", SINGLE): another}
    assert told(cells | {("gcivl", DOUBLE): {}}) == [
        "unequal data set on cube-single: 111111111111 (crl, gcivl); 222222222222 (qrl)"
    ]
