"""Side-by-side timings: contenders take turns, so that a busy machine slows all of them."""

import dataclasses
import statistics
import time
from collections.abc import Callable, Mapping, Sequence

_CALIBRATION = 3  # units, after the first, whose time determines how many fill a turn


@dataclasses.dataclass(frozen=True)
class Contender:
    """Something to time: `work(n)` does n units and returns when they are done.

    A unit is worth `items` of what is counted, such as the simulations that a step advances.
    """

    name: str
    work: Callable[[int], object]
    items: int = 1


@dataclasses.dataclass(frozen=True)
class Timing:
    """The measurements of a contender.

    Attributes:
        first: seconds that the first unit took, compilation included.
        seconds: seconds per item, one value per turn.
    """

    first: float
    seconds: Sequence[float]

    @property
    def median(self) -> float:
        """The median of `seconds`."""
        return statistics.median(self.seconds)

    def ratio(self, other: "Timing") -> float:
        """The median over turns of this one's seconds divided by the other's in the same turn."""
        turns = zip(self.seconds, other.seconds, strict=True)
        return statistics.median(mine / its for mine, its in turns)


def alternate(
    contenders: Sequence[Contender],
    *,
    turns: int,
    seconds: float,
    report: Callable[[str], object] = lambda _: None,
    clock: Callable[[], float] = time.perf_counter,
) -> Mapping[str, Timing]:
    """Timings of all contenders by name: `turns` turns each, of about `seconds`, in rotation.

    `report` is called with a contender's name after each of its turns, and once after its warm-up.
    """

    def time_of(contender: Contender, units: int) -> float:
        begin = clock()
        contender.work(units)
        return clock() - begin

    first, units = {}, {}
    for contender in contenders:
        first[contender.name] = time_of(contender, 1)
        once = time_of(contender, 1)
        if once < seconds:
            once = time_of(contender, _CALIBRATION) / _CALIBRATION
        units[contender.name] = max(1, round(seconds / once))
        report(contender.name)
    taken: dict[str, list[float]] = {contender.name: [] for contender in contenders}
    for _ in range(turns):
        for contender in contenders:
            count = units[contender.name]
            taken[contender.name].append(time_of(contender, count) / (count * contender.items))
            report(contender.name)
    return {name: Timing(first[name], tuple(taken[name])) for name in taken}
