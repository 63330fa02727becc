"""Writing an offline data set such that a crash at any moment costs at most one unfinished shard.

A shard that the manifest lists is complete. Anything else that a crash left behind is removed when
writing resumes.
"""

from collections.abc import Mapping
from pathlib import Path

from pigbench.data import manifest, shard
from pigbench.data.manifest import Manifest, Shard, Spec
from pigbench.data.shard import FieldArray
from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.compare import require_same


class Writer:
    """Writes a new data set, or continues one that was interrupted or lost files.

    Raises UserError if `folder` contains something else, or a data set of another specification.
    """

    def __init__(self, folder: Path, spec: Spec) -> None:
        self.folder = folder
        begun = _continue(folder, spec) if _is_begun(folder) else _begin(folder, spec)
        self._spec = begun.spec
        self._planned = len(begun.spec.plan())
        self._finished = {record.name: record for record in begun.shards}

    def missing(self) -> tuple[Shard, ...]:
        """The shards that are still to be written."""
        return tuple(part for part in self._spec.plan() if part.name not in self._finished)

    def write(self, part: Shard, arrays: Mapping[str, FieldArray], *, dropped: int = 0) -> None:
        """Write one shard, complete on return: the fields of its episodes except those `dropped`.

        Raises ValueError if the arrays do not match the specification.
        """
        record = shard.write(self.folder, self._spec, part, arrays, dropped=dropped)
        manifest.add(self.folder, record)
        self._finished[record.name] = record
        if len(self._finished) == self._planned:
            complete = Manifest(self._spec, ()).with_shards(self._finished.values())
            manifest.write(self.folder, complete)


def _is_begun(folder: Path) -> bool:
    return (folder / manifest.FILE_NAME).exists()


def _begin(folder: Path, spec: Spec) -> Manifest:
    own = {files.temporary_path(folder / manifest.FILE_NAME).name}
    if folder.exists() and not (folder.is_dir() and files.entries(folder) <= own):
        raise UserError(f"{folder} is not an empty folder and holds no data set; choose another")
    files.make_folder(folder)
    begun = Manifest(spec, ())
    manifest.write(folder, begun)
    return begun


def _continue(folder: Path, spec: Spec) -> Manifest:
    stored = manifest.read(folder)
    require_same(str(folder), stored.spec.as_dict(), spec.as_dict())
    whole = stored.with_shards(
        record for record in stored.shards if not any(shard.file_problems(folder, record))
    )
    if whole != stored or (folder / manifest.JOURNAL).exists():
        manifest.write(folder, whole)
    for part in whole.missing():
        files.remove_folder(folder / part.name)
        files.remove_folder(files.temporary_path(folder / part.name))
    return whole
