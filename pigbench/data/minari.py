"""Minari's data set format, stored with Arrow, as read by `minari.load_dataset`.

The folder contains Minari data sets, one per split, like the folder `MINARI_DATASETS_PATH`:

pigbench/cube-single-play-v0/data/metadata.json      spaces, environment, sizes
pigbench/cube-single-play-v0/data/0/part-0.arrow     the first episode, one row per state
pigbench/cube-single-play-v0/data/0/metadata.json    its number and length

Rewards are 0, since episodes have no goal; they end by truncation.
"""

import itertools
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from jaxtyping import Float

from pigbench import envs, gym
from pigbench.data.dataset import ENDINGS, Dataset, Split
from pigbench.data.manifest import Spec, provenance
from pigbench.data.shard import FieldArray
from pigbench.support import files, lock
from pigbench.support.extras import required
from pigbench.support.progress import Progress

VERSION = "0.5.4"  # of Minari, which defines the format


def write(dataset: Dataset, path: Path) -> list[Path]:
    """Write the data set to the new folder `path`, completely or not at all, and return `[path]`.

    Raises UserError if `path` already exists, pyarrow is not installed, or the environment, which
    the format describes, is unknown.
    """
    required("pyarrow.ipc", extra="share")
    envs.get(dataset.spec.environment)
    files.require_new_folder(path)
    splits = {identify(dataset, name): split for name, split in dataset.splits.items()}
    total = sum(split.rows for split in splits.values())
    with (
        lock.replacing_folder(path) as new,
        Progress("export", total=total, unit="rows") as progress,
    ):
        for identity, split in splits.items():
            _write_split(new / identity / "data", identity, split, progress)
    return [path]


def identify(dataset: Dataset, split: str) -> str:
    """A split's name in Minari."""
    spec = dataset.spec
    policy = re.sub(r"[^A-Za-z0-9_.]+", "-", spec.policy)
    return f"pigbench/{spec.environment}-{policy}{ENDINGS[split]}-v0"


def _write_split(folder: Path, identity: str, split: Split, progress: Progress) -> None:
    shards = (split.shard_episodes(one, "observations", "actions") for one in split.records)
    count = size = 0
    for number, episode in enumerate(itertools.chain.from_iterable(shards)):
        own = folder / str(number)
        own.mkdir(parents=True)
        _write_episode(own / "part-0.arrow", episode)
        rows = len(episode["observations"])
        about = json.dumps({"id": number, "total_steps": rows - 1})
        (own / "metadata.json").write_text(about, encoding="utf-8")
        count, size = number + 1, size + (own / "part-0.arrow").stat().st_size
        progress.advance(rows)
    about = _metadata(identity, split) | {
        "total_episodes": count,
        "total_steps": split.rows - count,
        "dataset_size": round(size / 1e6, 1),  # MB
    }
    files.write_json(folder / "metadata.json", about)


def _write_episode(path: Path, episode: Mapping[str, FieldArray]) -> None:
    """Write one row per state; the last state has no action, and zeros in its place."""
    pa, ipc = required("pyarrow", "pyarrow.ipc", extra="share")
    observations, actions = np.asarray(episode["observations"]), np.array(episode["actions"])
    actions[-1] = 0
    rows = np.arange(len(actions))

    def vectors(values: Float[np.ndarray, "row n"]) -> Any:
        kind = pa.list_(pa.float32(), values.shape[1])
        return pa.FixedSizeListArray.from_arrays(values.ravel(), type=kind)

    batch = pa.RecordBatch.from_pydict(
        {
            "observations": vectors(observations),
            "actions": vectors(actions),
            "rewards": np.zeros(len(rows)),
            "terminations": np.zeros(len(rows), bool),
            "truncations": rows == len(rows) - 2,
        }
    )
    with ipc.new_file(path, batch.schema) as file:
        file.write_batch(batch)


def _metadata(identity: str, split: Split) -> dict[str, Any]:
    spec = split.spec
    gym.register()  # a plugin's environments too
    environment = gymnasium.spec(gym.env_id(spec.environment))
    return {
        "dataset_id": identity,
        "minari_version": VERSION,
        "data_format": "arrow",
        "jpeg_encoding": False,
        "env_spec": environment.to_json(),
        "observation_space": _box(spec.layout.size, np.inf),
        "action_space": _box(spec.action_size, 1.0),
        "algorithm_name": spec.policy,
        "description": f"{spec.policy} data of {spec.environment}, {_source(spec)}; rewards are 0: "
        "any state may be the goal",
    }


def _source(spec: Spec) -> str:
    if spec.is_imported:
        return f"imported by pigbench from {provenance(spec)['imported from']}"
    return f"made by pigbench with seed {spec.seed} (physics profile {spec.physics})"


def _box(size: int, bound: float) -> str:
    """A box in R^size, in Minari's notation of spaces."""
    limits = {"low": [-bound] * size, "high": [bound] * size}
    return json.dumps({"type": "Box", "dtype": "float32", "shape": [size], **limits})
