"""Rows within a time limit, under a clock that only work moves."""

import pytest

from pigbench.bench import budget
from pigbench.bench.budget import FAILED, FIRST, KILLED, RATE, SKIPPED, Row


class Bench:
    """Rows that take a given time, and what is kept of them."""

    def __init__(self):
        self.now, self.measured, self.kept, self.results = 0.0, [], [], {}

    def row(self, series, size, *, seconds, rate=1.0, first=0.0, error=None, estimate=1.0, kind=""):
        def measure():
            self.now += seconds
            self.measured.append((series, size))
            if error:
                raise error
            return {RATE: rate, FIRST: first}

        return Row(kind or series, series, size, {}, measure, estimate)

    def run(self, rows, *, deadline=1e9, **options):
        budget.run(
            rows,
            self.results,
            deadline=deadline,
            keep=lambda: self.kept.append(dict(self.results)),
            clock=lambda: self.now,
            **options,
        )

    def reason(self, name):
        return self.results[name].get(SKIPPED) or self.results[name].get(FAILED)


@pytest.fixture
def bench():
    return Bench()


def test_a_row_that_fails_says_why_and_the_rest_goes_on(bench):
    error = RuntimeError("RESOURCE_EXHAUSTED:\n  out of memory")
    rows = [bench.row("a", 1, seconds=1, error=error), bench.row("b", 1, seconds=2, rate=3.0)]
    bench.run(rows)
    assert bench.reason("a, 1") == "RuntimeError: RESOURCE_EXHAUSTED: out of memory"
    assert bench.results["b, 1"] == {RATE: 3.0, FIRST: 0.0, "took_s": 2.0}


def test_a_series_ends_where_a_row_fails_or_brings_no_more(bench):
    rows = [
        bench.row("full", 1, seconds=1, rate=10.0),
        bench.row("full", 4, seconds=1, rate=20.0),
        bench.row("full", 16, seconds=1, rate=20.5),
        bench.row("full", 64, seconds=1, rate=90.0),
        bench.row("full", 256, seconds=1, rate=90.0),
        bench.row("big", 1, seconds=1, error=MemoryError()),
        bench.row("big", 4, seconds=1),
    ]
    bench.run(rows)
    assert bench.measured == [("full", 1), ("full", 4), ("full", 16), ("big", 1)]
    assert bench.reason("full, 64") == bench.reason("full, 256") == "the rate rises no more"
    assert bench.reason("big, 4") == "a smaller one failed"


def test_no_row_starts_that_would_end_too_late(bench):
    """Eight seconds of the first row's ten do not grow with size, two do."""
    rows = [
        bench.row("a", 1, seconds=10, rate=1.0, first=8),
        bench.row("a", 4, seconds=16, rate=2.0, first=8),  # expected to take 8 + 4 x 2
        bench.row("b", 1, seconds=5, estimate=4.5),
        bench.row("c", 1, seconds=1, estimate=4.5),
        bench.row("d", 1, seconds=1, estimate=1.0),
    ]
    bench.run(rows, deadline=31.0)
    assert bench.measured == [("a", 1), ("a", 4), ("b", 1)]
    assert bench.reason("c, 1") == bench.reason("d, 1") == "no time left"
    bench.measured.clear()
    bench.results.clear()
    bench.now = 0.0
    bench.run(rows, deadline=25.9)
    assert bench.measured == [("a", 1), ("b", 1), ("c", 1), ("d", 1)]


def test_a_kind_tells_how_long_its_other_series_take(bench):
    rows = [
        bench.row("a", 1, seconds=10, kind="steps"),
        bench.row("b", 1, seconds=10, kind="steps", estimate=1.0),
    ]
    bench.run(rows, deadline=15.0)
    assert bench.measured == [("a", 1)]


def test_skipped_rows_are_tried_again_and_others_kept(bench):
    rows = [
        bench.row("a", 1, seconds=1),
        bench.row("b", 1, seconds=1, error=ValueError("no")),
        bench.row("c", 1, seconds=1, estimate=50.0),
    ]
    bench.run(rows, deadline=10.0)
    assert bench.reason("c, 1") == "no time left"
    bench.measured.clear()
    bench.run(rows, deadline=100.0)
    assert bench.measured == [("c", 1)]


def test_what_ended_the_process_is_down_as_that(bench):
    """What is kept when a row is under way is what a killed process leaves behind."""
    rows = [bench.row("a", 1, seconds=1), bench.row("b", 1, seconds=1)]
    bench.run(rows)
    assert bench.kept[0] == {"a, 1": {FAILED: KILLED}}
    assert RATE in bench.kept[1]["a, 1"]
    bench.results, bench.measured = dict(bench.kept[0]), []
    bench.run(rows)
    assert bench.measured == [("b", 1)]


def test_an_interrupted_row_is_measured_another_time(bench):
    with pytest.raises(KeyboardInterrupt):
        bench.run([bench.row("a", 1, seconds=1, error=KeyboardInterrupt())])
    assert bench.kept[-1] == {}


def test_a_device_that_is_lost_is_asked_no_more(bench):
    rows = [
        bench.row("a", 1, seconds=1, error=RuntimeError("illegal address")),
        bench.row("b", 1, seconds=1),
    ]
    bench.run(rows, alive=lambda: False)
    assert bench.measured == [("a", 1)]
    assert "no longer answers" in bench.reason("b, 1")
    bench.run(rows)
    assert bench.measured == [("a", 1), ("b", 1)]
