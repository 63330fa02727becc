"""What is bold in a table: the best of each line."""

from collections.abc import Callable, Mapping, Sequence

from pigbench.report.bootstrap import LEVEL
from pigbench.report.formats import Label
from pigbench.report.stats import Estimate
from pigbench.support.grouping import grouped


def best(estimates: Mapping[Label, Estimate], line: Callable[[Label], str]) -> set[Label]:
    """The highest of each line, and what is in its interval; none of a line with one number."""
    lines = grouped(estimates, line).values()
    return {label for labels in lines if len(labels) > 1 for label in _highest(estimates, labels)}


def _highest(estimates: Mapping[Label, Estimate], labels: Sequence[Label]) -> list[Label]:
    best = max((estimates[label] for label in labels), key=lambda estimate: estimate.value)
    least = best.interval.low if best.interval else best.value
    return [label for label in labels if estimates[label].value >= least]


def meaning(estimates: Mapping[Label, Estimate], *, line: str) -> str:
    """What bold means in a table whose lines are each a `line`."""
    if has_intervals(estimates):
        return f"Bold: the highest of a {line} and what lies in its {LEVEL} % bootstrap interval"
    return f"Bold: the highest of a {line}; a single seed gives no interval"


def has_intervals(estimates: Mapping[Label, Estimate]) -> bool:
    """Whether an estimate has an interval: one of several seeds does."""
    return any(estimate.interval for estimate in estimates.values())
