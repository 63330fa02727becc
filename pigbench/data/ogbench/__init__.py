"""OGBench's files: `F.npz` for training and `F-val.npz` for validation, one array per field.

Their rows are those of our shards, one after another: whole episodes, with `terminals` true on the
last row. Files of what OGBench's loaders return are read too: with `valids`, false on an episode's
last row, or with `next_observations`, where a row is a transition. Data are processed file by file,
large files in pieces.

For `-oraclerep` environments, OGBench's loader computes goals, `oracle_reps`, from qpos. An export
may include them ready-made, for readers without that loader.
"""

from pigbench.data.ogbench.reading import read
from pigbench.data.ogbench.writing import write

__all__ = ["read", "write"]
