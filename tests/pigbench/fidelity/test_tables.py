"""Tables of numbers made by hand."""

import numpy as np

from pigbench.envs.contact import CARRYING, FREE
from pigbench.fidelity import tables
from pigbench.fidelity.closed_loop import Successes
from pigbench.fidelity.distributions import Comparison
from pigbench.fidelity.replay import WINDOW, Errors, Outcomes, Windows


def test_errors_are_percentiles_over_windows_in_each_situation():
    """Two windows; the second one carries from the tenth step on."""
    situations = np.full((WINDOW, 2), FREE, dtype="<U9")
    situations[9:, 1] = CARRYING
    cube = np.zeros((WINDOW, 2))
    cube[0] = [0.001, 0.003]
    cube[9] = [0.00005, 0.002]
    zero = np.zeros((WINDOW, 2))
    turn = np.full((WINDOW, 2), np.pi)
    errors = Errors(pinch=zero, opening=zero, contact=zero, cube=cube, turn=turn)
    header, *lines = tables.errors({("mujoco", "exact"): Windows(situations, errors)})
    by_place = {line[2:4]: dict(zip(header, line, strict=True)) for line in lines}
    assert list(by_place) == [
        *((FREE, steps) for steps in ("1", "10", "50")),
        *((CARRYING, steps) for steps in ("10", "50")),
    ]
    first = by_place[FREE, "1"]
    assert (first["engine"], first["physics"], first["windows"]) == ("mujoco", "exact", "2")
    assert first["cube (mm)"] == "2.9"  # 1 + 0.95 (3 - 1)
    assert (first["cube within 0.1 mm"], first["2 mm"]) == ("0.0 %", "50.0 %")
    assert first["turn (deg)"] == "1.8e+02"
    assert by_place[FREE, "10"]["cube within 0.1 mm"] == "100.0 %"
    assert by_place[CARRYING, "10"]["cube (mm)"] == "2"


def test_outcomes_are_shares_of_the_same():
    yes, no = np.array([True, True, True, True]), np.array([True, False, True, True])
    table = tables.outcomes({("mujoco", "fast"): Outcomes(yes, no, no, no)})
    assert table[1] == ("mujoco", "fast", "4", "75.0 %", "100.0 %")


def test_quantities_are_named_with_their_policy():
    found = {"a cube on another": Comparison(0.25, 0.125, 0.5, 0.04)}
    table = tables.quantities([("play", found)])
    assert table[1] == ("a cube on another", "play", "0.25", "0.125", "0.50", "0.04")


def test_pairs_are_counted_by_task_and_in_all():
    """Six pairs differ, all in our favour: p = 2 / 2^6."""
    ours, theirs = np.ones((2, 4), bool), np.zeros((2, 4), bool)
    theirs[0, :2] = True
    header, first, second, together = tables.pairs(["one", "two"], Successes(ours, theirs))
    assert first == ("one", "2", "2", "0", "0", "100.0 %", "50.0 %", "0.5")
    assert second == ("two", "0", "4", "0", "0", "100.0 %", "0.0 %", "0.12")
    assert together == ("all tasks", "2", "6", "0", "0", "100.0 %", "25.0 %", "0.031")
    assert header[1:5] == ("both succeed", "only pigbench", "only ogbench", "neither")
