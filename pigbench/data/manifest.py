"""A data set's description of itself: its specification and one record per finished shard.

The manifest is the file `manifest.json` in a data set's folder. It has no timestamps, and its
shards are in the order of the plan, whatever order they were written in: same data, same bytes.
While a data set is being written, `shards.jsonl` beside it lists further finished shards, one per
line: rewriting the manifest for every shard would cost the square of their number.
"""

import dataclasses
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import pydantic

from pigbench.errors import UserError
from pigbench.layout import Layout
from pigbench.support import files, schema

FORMAT = 1
FILE_NAME = "manifest.json"
JOURNAL = "shards.jsonl"
FILTERED_BY = "filtered by"  # in the origin of data that are the good episodes of others


class Shard(NamedTuple):
    """One unit of work of a data set.

    `number` is unique over all splits, so that `fold_in(seed, number)` is the shard's random key.
    """

    name: str
    split: str
    number: int
    episodes: int


def _layout(terms: Any) -> Any:
    """Its fields, as `Spec.as_dict` has it without their name."""
    return {"terms": terms} if isinstance(terms, list) else terms


@dataclasses.dataclass(frozen=True)
class Spec:
    """Everything that identifies a data set before it exists.

    Attributes:
        environment: the environment's name.
        policy: the name of the collecting policy.
        physics: the physics profile, `exact` or `fast`.
        engine: the physics engine; of no meaning for imported data.
        seed: the seed from which every random key is derived; of no meaning for imported data.
        episodes: the number of episodes to simulate for each split, including those that diverge.
        episodes_per_shard: the number of episodes per shard; if unequal, a number for each shard by
            split.
        rows_per_episode: the rows of an episode, including its last state; 0 if they differ.
        fields: names of the stored fields, from `pigbench.data.shard.DTYPES`.
        layout: the terms of an observation.
        action_size: the size of an action.
        versions: versions of the packages that the numbers depend on; empty for imported data.
        settings: other settings that they depend on, from `pigbench.settings.in_force`; empty for
            imported data.
        origin: what imported or filtered data were made from, and how.
    """

    environment: str
    policy: str
    physics: str
    engine: str
    seed: int
    episodes: Mapping[str, int]
    episodes_per_shard: int | Mapping[str, tuple[int, ...]]
    rows_per_episode: int
    fields: tuple[str, ...]
    layout: Annotated[Layout, pydantic.BeforeValidator(_layout)]
    action_size: int
    versions: Mapping[str, str]
    settings: Mapping[str, str] = dataclasses.field(default_factory=dict)
    origin: Mapping[str, str] = dataclasses.field(default_factory=dict)

    @property
    def is_imported(self) -> bool:
        """Whether the data come from elsewhere, so that no engine and no seed made them."""
        return not self.versions

    @property
    def is_compact(self) -> bool:
        """Whether the simulator's own states are left out."""
        return not {"qpos", "qvel"} & set(self.fields)

    @property
    def is_filtered(self) -> bool:
        """Whether the data are the good episodes of others."""
        return FILTERED_BY in self.origin

    def as_dict(self) -> dict[str, Any]:
        """The specification in plain types; its layout is the (name, size) of each term.

        An empty origin is left out, so that generated data have the digests that runs in results/
        name.
        """
        content = {**dataclasses.asdict(self), "layout": self.layout.terms}
        return content if self.origin else {k: v for k, v in content.items() if k != "origin"}

    def as_json(self) -> str:
        """The specification as JSON, the inverse of `spec_of`."""
        return json.dumps(self.as_dict())

    def plan(self) -> tuple[Shard, ...]:
        """The shards of the complete data set."""
        pieces = [
            (f"{split}-{position:05d}", split, episodes)
            for split, asked in sorted(self.episodes.items())
            for position, episodes in enumerate(self._shard_sizes(split, asked))
        ]
        return tuple(
            Shard(name, split, number, episodes)
            for number, (name, split, episodes) in enumerate(pieces)
        )

    def _shard_sizes(self, split: str, asked: int) -> Iterable[int]:
        most = self.episodes_per_shard
        if isinstance(most, int):
            return (min(most, asked - start) for start in range(0, asked, most))
        return most[split]


@dataclasses.dataclass(frozen=True)
class FileRecord:
    """The hash and size that identify a file's content."""

    sha256: str
    bytes: int

    @classmethod
    def of(cls, path: Path) -> "FileRecord":
        """The record of the file `path` in its current state."""
        return cls(sha256=files.sha256(path), bytes=path.stat().st_size)


@dataclasses.dataclass(frozen=True)
class ShardRecord:
    """A finished shard: its contents, and its files by name."""

    name: str
    split: str
    episodes: int
    dropped: int
    rows: int
    files: Mapping[str, FileRecord]


@dataclasses.dataclass(frozen=True)
class Manifest:
    """A data set's specification and its finished shards."""

    spec: Spec
    shards: tuple[ShardRecord, ...]

    def missing(self) -> tuple[Shard, ...]:
        """The shards of the plan that are not finished."""
        finished = {shard.name for shard in self.shards}
        return tuple(shard for shard in self.spec.plan() if shard.name not in finished)

    def with_shards(self, shards: Iterable[ShardRecord]) -> "Manifest":
        """This manifest with `shards` instead of its own, in the order of the plan."""
        records = {record.name: record for record in shards}
        planned = (shard.name for shard in self.spec.plan())
        return dataclasses.replace(
            self, shards=tuple(records[name] for name in planned if name in records)
        )


def remaining(folder: Path) -> str | None:
    """What is left to do on the data set in `folder`, in words; None if it is complete.

    A journal left by a kill is not complete: the manifest, whose bytes give the digest, does not
    list all shards yet. Raises UserError as `read` does.
    """
    manifest = read(folder)
    if missing := manifest.missing():
        return f"{len(missing)} of {len(manifest.spec.plan())} shards are missing"
    if (folder / JOURNAL).exists():
        return f"{JOURNAL} is still to be taken into {FILE_NAME}"
    return None


def digest(folder: Path) -> str:
    """The SHA-256 of the manifest in `folder`: of the data set, once it is complete."""
    return files.sha256(folder / FILE_NAME)


def write(folder: Path, manifest: Manifest) -> None:
    """Replace the manifest of the data set in `folder`, and remove the journal."""
    shards = [dataclasses.asdict(record) for record in manifest.shards]
    content = {"format": FORMAT, "spec": manifest.spec.as_dict(), "shards": shards}
    files.write_sealed(folder / FILE_NAME, content)
    (folder / JOURNAL).unlink(missing_ok=True)


def add(folder: Path, record: ShardRecord) -> None:
    """Add a finished shard to the data set in `folder`, at constant cost."""
    files.append_line(folder / JOURNAL, json.dumps(files.sealed(dataclasses.asdict(record))))


def read(folder: Path) -> Manifest:
    """The manifest of the data set in `folder`.

    Raises UserError if there is none, if it is torn or invalid, or if its format is not that of
    this version.
    """
    path = folder / FILE_NAME
    if not folder.is_dir():
        raise UserError(f"{folder} does not exist; make a data set with `pigbench generate`")
    if not path.exists():
        raise UserError(f"{folder} is not a data set: it has no {FILE_NAME}")
    content = files.read_sealed(path)
    version = content.pop("format", None)
    if version != FORMAT:
        raise UserError(f"{path} has format {version!r}; this version reads format {FORMAT}")
    manifest = schema.read(Manifest, content, f"{path} is invalid")
    added = _journal(folder)
    return manifest.with_shards([*manifest.shards, *added]) if added else manifest


def spec_of(content: str) -> Spec:
    """The specification whose `as_json` is given."""
    return schema.read(Spec, json.loads(content), "the specification is invalid")


def provenance(spec: Spec) -> dict[str, str]:
    """How the data came about, by name; a text is empty if there is nothing to say."""
    if spec.is_imported:
        return {
            "imported from": _listed(spec.origin),
            "physics": f"profile {spec.physics} in evaluations",
        }
    return {
        "physics": f"profile {spec.physics}, engine {spec.engine}",
        "seed": str(spec.seed),
        "versions": _listed(spec.versions),
        "settings": _listed({name: value for name, value in spec.settings.items() if value}),
        "origin": _listed(spec.origin),
    }


def describe(manifest: Manifest) -> str:
    """A readable summary of the data set in a few lines."""
    spec, shards = manifest.spec, manifest.shards
    lines = {
        "environment": spec.environment,
        "policy": spec.policy,
        **provenance(spec),
        "fields": ", ".join(spec.fields),
        "action size": spec.action_size,
        "shards": f"{len(shards)} of {len(spec.plan())}",
        "bytes": f"{sum(file.bytes for shard in shards for file in shard.files.values()):,}",
    }
    for split, asked in spec.episodes.items():
        parts = [shard for shard in shards if shard.split == split]
        lines[split] = (
            f"{sum(part.rows for part in parts):,} rows, "
            f"{sum(part.episodes for part in parts):,} of {asked:,} episodes, "
            f"{sum(part.dropped for part in parts):,} dropped as diverged"
        )
    lines["observation"] = f"{spec.layout.size} numbers"
    for name, part in spec.layout.items():
        lines[f"  {name}"] = f"[{part.start}:{part.stop}]"
    width = max(map(len, lines))
    return "\n".join(f"{name:<{width}}  {text}" for name, text in lines.items() if text != "")


def _listed(values: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())


def _journal(folder: Path) -> list[ShardRecord]:
    """The added records; a last line that a crash cut off is left out."""
    path = folder / JOURNAL
    text = files.read_text(path) if path.exists() else ""
    lines = [line for line in text.splitlines(keepends=True) if line.endswith("\n")]
    with files.explaining_torn(path):
        records = [files.unsealed(path, json.loads(line)) for line in lines]
    return [schema.read(ShardRecord, record, f"{path} is invalid") for record in records]
