"""The card of a data set: a README with the folder's contents and how to load them."""

from pathlib import Path

from pigbench.data import manifest
from pigbench.data.dataset import Dataset
from pigbench.sharing import card
from pigbench.support import files

_SIZES = {1e3: "1K", 1e4: "10K", 1e5: "100K", 1e6: "1M", 1e7: "10M", 1e8: "100M", 1e9: "1B"}

_NUMPY = """
import numpy as np

observations = np.load("{shard}/observations.npy", mmap_mode="r")  # (rows, {size}) in float32
actions = np.load("{shard}/actions.npy", mmap_mode="r")  # (rows, {action_size}) in float32
terminals = np.load("{shard}/terminals.npy")  # true in an episode's last row
"""

_PIGBENCH = """
pigbench data verify .
pigbench train gcivl --data . --out run
"""


_SIMULATED = "simulated in pigbench's reimplementation of OGBench's cube environments."
_IMPORTED = "imported into pigbench from files made elsewhere."


def write(dataset: Dataset, *, license: str = card.LICENSE) -> Path:
    """Write the card into the data set's folder, replacing any existing one."""
    path = dataset.folder / card.FILE_NAME
    files.write_text(path, describe(dataset, license=license))
    return path


def describe(dataset: Dataset, *, license: str = card.LICENSE) -> str:
    """The card's text."""
    spec, shards = dataset.spec, dataset.manifest.shards
    rows = sum(shard.rows for shard in shards)
    size = sum(file.bytes for shard in shards for file in shard.files.values())
    splits = {
        f"split {name}": f"rows {sum(shard.rows for shard in shards if shard.split == name):,}, "
        f"episodes {sum(shard.episodes for shard in shards if shard.split == name):,}"
        for name in spec.episodes
    }
    usage = _NUMPY.format(shard=shards[0].name, size=spec.layout.size, action_size=spec.action_size)
    return card.card(
        {
            "license": license,
            "pretty_name": f"{spec.environment}, {spec.policy}",
            "task_categories": ["reinforcement-learning", "robotics"],
            "size_categories": [_category(rows)],
            "tags": [*card.TAGS, spec.environment],
        },
        f"# {spec.environment}, {spec.policy}",
        "Rows of whole episodes for offline goal-conditioned reinforcement learning, "
        + (_IMPORTED if spec.is_imported else _SIMULATED),
        card.facts(
            {
                "environment": spec.environment,
                "policy": spec.policy,
                **manifest.provenance(spec),
                **splits,
                "fields": ", ".join(spec.fields),
                "size": f"{size / 1e6:,.1f} MB",
                "manifest's SHA-256": dataset.digest,
            }
        ),
        f"## Loading\n\nA shard at a time, in this folder:\n\n{card.code('python', usage)}\n\n"
        f"With pigbench:\n\n{card.code('sh', _PIGBENCH)}",
        "## Observations and actions",
        card.observation_table(spec.environment, spec.layout),
        card.ACTION,
        "`manifest.json` has the SHA-256 of every file.",
    )


def _category(rows: int) -> str:
    """The hub's category for a number of rows."""
    names = list(_SIZES.values())
    place = sum(rows >= bound for bound in _SIZES)
    if place == 0:
        return f"n<{names[0]}"
    return f"{names[place - 1]}<n<{names[place]}" if place < len(names) else f"n>{names[-1]}"
