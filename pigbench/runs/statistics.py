"""The statistics of the data from which a run learns, as kept in its folder."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pigbench.support import files

if TYPE_CHECKING:  # tables read runs without agents and JAX
    from pigbench.agents import Statistics


def write_statistics(path: Path, statistics: "Statistics") -> None:
    """Write them, with a checksum."""
    content = {name: values.tolist() for name, values in statistics._asdict().items()}
    files.write_sealed(path, content)


def read_statistics(path: Path) -> "Statistics":
    """Read them. Raises UserError if there are none."""
    from pigbench.agents import Statistics

    content = files.read_sealed(path)
    with files.explaining_torn(path):
        return Statistics(
            **{name: np.asarray(values, np.float32) for name, values in content.items()}
        )
