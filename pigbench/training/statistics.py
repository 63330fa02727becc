"""The statistics of the data from which a run learns, as kept in its folder."""

from typing import TYPE_CHECKING

import numpy as np

from pigbench.support import files

if TYPE_CHECKING:  # tables read runs without agents and JAX
    from pigbench.agents import Statistics
    from pigbench.training.run import Run


def write_statistics(run: "Run", statistics: "Statistics") -> None:
    """Write them, with a checksum."""
    content = {name: values.tolist() for name, values in statistics._asdict().items()}
    files.write_json(run.statistics_path, files.sealed(content))


def read_statistics(run: "Run") -> "Statistics | None":
    """The statistics of the data from which the run learns; None for old runs without any."""
    from pigbench.agents import Statistics

    path = run.statistics_path
    if not path.exists():
        return None
    content = files.read_json(path)
    with files.explaining_torn(path):
        return Statistics(
            **{name: np.asarray(values, np.float32) for name, values in content.items()}
        )
