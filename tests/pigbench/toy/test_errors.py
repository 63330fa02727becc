import csv
import io

import numpy as np
import pytest

from pigbench.toy import errors
from pigbench.toy.hybrid import HYBRID
from pigbench.toy.settings import Settings
from pigbench.toy.study import SIDE, ToyOutcome

HOLDING = HYBRID.fits[0][1]
SETTINGS = Settings(half_width=2.0)


@pytest.fixture
def outcome():
    """d* = |x_a|: one fit 0.25 too high everywhere, one 0.05 too low where |x_a| < 0.1."""
    positions = np.tile(np.linspace(-2, 2, SIDE), SIDE)
    truth = np.abs(positions)
    fits = [truth + 0.25, truth - 0.05 * (truth < 0.1)]
    return ToyOutcome(HOLDING, "hjb", np.stack(fits), np.zeros((2, SIDE)))


def test_errors_are_signed(outcome):
    low, high = np.percentile(errors.errors(outcome, SETTINGS), [0, 100])
    assert (low, high) == (pytest.approx(-0.05, abs=1e-6), pytest.approx(0.25, abs=1e-6))


def test_measures_by_hand(outcome):
    """Grid lines are 0.04 apart, so 5 of 101 lie within 0.1 of the kink."""
    ((names, row),) = errors.estimates([outcome], SETTINGS).items()
    assert names == ("holding", "hjb")
    seeds = [(0.25, 0.05 * 5 / 101), (0.25, 0.0), (1.0, 0.0)]
    for number, (first, second) in zip(row.values(), seeds, strict=True):
        assert number.value == pytest.approx((first + second) / 2, abs=1e-6)
        assert number.deviation == pytest.approx((first - second) / 2**0.5, abs=1e-6)
        assert number.seeds == 2


def test_tables_hold_every_number(outcome):
    found = errors.estimates([outcome], SETTINGS)
    header, _, line = errors.markdown(found).splitlines()
    assert header.startswith("| mode    | loss | mean absolute error |")
    assert "0.1250 ± 0.1768" in line
    rows = list(csv.DictReader(io.StringIO(errors.comma_separated(found))))
    assert [row["measure"] for row in rows] == list(errors.MEASURES)
    assert float(rows[1]["mean"]) == pytest.approx(0.125, abs=1e-6)


def test_a_single_seed_has_no_deviation(outcome):
    found = errors.estimates([outcome._replace(grid=outcome.grid[:1])], SETTINGS)
    assert "±" not in errors.markdown(found)
