"""The names of OGBench's files and of the arrays in them."""

from pathlib import Path

from pigbench.data.dataset import ENDINGS
from pigbench.errors import UserError

SUFFIX = ".npz"
NEXT, VALIDS, ORACLE_REPS = "next_observations", "valids", "oracle_reps"
"""The arrays that are no fields of a shard."""


def split_paths(path: Path) -> dict[str, Path]:
    """The file of each split, given the training file. Raises UserError unless it ends in .npz."""
    if path.suffix != SUFFIX:
        raise UserError(f"{path} does not end in {SUFFIX}, as OGBench's files do")
    return {split: path.with_stem(path.stem + ending) for split, ending in ENDINGS.items()}
