"""What captions of tables say of the results, and how they were obtained."""

from collections.abc import Mapping

from pigbench import envs
from pigbench.report import comparison
from pigbench.report.bootstrap import LEVEL
from pigbench.report.formats import Label
from pigbench.report.scoring import Cells, Scoring, score_remarks, wording
from pigbench.report.stats import Estimate
from pigbench.report.tables import bold
from pigbench.report.tables.labels import centimetres
from pigbench.support.grouping import grouped


def success_rates(
    cells: Cells,
    estimates: Mapping[Label, Estimate],
    scoring: Scoring,
    *,
    line: str,
) -> str:
    """The caption of success rates, of which the best of each `line` are bold."""
    return (
        f"Success rate in percent ({conditions(cells, scoring)}), mean ± standard deviation over "
        f"seeds. {bold.meaning(estimates, line=line)}"
    )


def conditions(cells: Cells, scoring: Scoring) -> str:
    """The evaluations that count, and the conditions that readers must know."""
    told = score_remarks(cells, scoring, always=("physics",))
    return "; ".join([wording(cells, scoring), *told])


def success_distances(cells: Cells) -> str:
    """That success ends an episode, and how near that is in the environments known here."""
    own = {cell.environment for cell in cells} & envs.SPECS.keys()
    by_distance = grouped(sorted(own), lambda name: envs.SPECS[name].success_distance)
    within = ", ".join(
        f"{centimetres(distance)} cm"
        + (f" in {' and '.join(by_distance[distance])}" if len(by_distance) > 1 else "")
        for distance in sorted(by_distance)
    )
    return f"success (within {within}) ends an episode" if within else "success ends an episode"


def pooling(pooled: comparison.Pool, estimates: Mapping[Label, Estimate], scoring: Scoring) -> str:
    """Over what the numbers are pooled, and their intervals if they have some."""
    over = {"environments": "over", "tasks": "over the tasks of"}[scoring.over]
    intervals = (
        f", with {LEVEL} % stratified bootstrap intervals over seeds"
        if bold.has_intervals(estimates)
        else ""
    )
    return f"{over} {', '.join(pooled.environments)}{intervals}"
