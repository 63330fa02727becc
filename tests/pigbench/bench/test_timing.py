import pytest

from pigbench.bench.timing import Contender, Timing, alternate


class FakeClock:
    """A clock that only work moves: each unit by a given time, the first by 10 s more."""

    def __init__(self):
        self.now = 0.0
        self.turns = []

    def __call__(self):
        return self.now

    def contender(self, name, seconds, items=1):
        started = []

        def work(units):
            self.turns.append((name, units))
            self.now += units * seconds + (0 if started else 10)
            started.append(True)

        return Contender(name, work, items)


def test_contenders_take_turns_of_about_the_same_length():
    clock = FakeClock()
    contenders = [clock.contender("quick", 0.01), clock.contender("slow", 3.0)]
    timings = alternate(contenders, turns=2, seconds=1.0, clock=clock)
    # Once to compile, once to see how long it takes, three times more to see better if it is quick.
    warming_up = [("quick", 1), ("quick", 1), ("quick", 3), ("slow", 1), ("slow", 1)]
    assert clock.turns == [*warming_up, ("quick", 100), ("slow", 1), ("quick", 100), ("slow", 1)]
    assert timings["quick"].first == pytest.approx(10.01)
    assert timings["quick"].seconds == pytest.approx([0.01, 0.01])
    assert timings["slow"].seconds == pytest.approx([3.0, 3.0])


def test_a_unit_of_many_items_is_shared_among_them():
    clock = FakeClock()
    timings = alternate([clock.contender("batch", 0.5, 100)], turns=1, seconds=1.0, clock=clock)
    assert timings["batch"].seconds == pytest.approx([0.005])


def test_ratios_are_of_the_same_turn():
    """A machine that is busy in the middle turn slows both: the ratio stays 2."""
    mine, its = Timing(0.0, (2.0, 20.0, 2.2)), Timing(0.0, (1.0, 10.0, 1.1))
    assert mine.ratio(its) == pytest.approx(2.0)
    assert mine.median == 2.2


def test_each_turn_is_reported():
    clock, names = FakeClock(), []
    contenders = [clock.contender("a", 1.0), clock.contender("b", 1.0)]
    alternate(contenders, turns=1, seconds=1.0, clock=clock, report=names.append)
    assert names == ["a", "b", "a", "b"]
