"""Data sets on the Hugging Face hub: a repository holds the very files of a data set's folder.

The hub's own library does the work and reads its own variables (`HF_TOKEN`, `HF_ENDPOINT`). It
resumes interrupted transfers: files that are already there are not sent again.
"""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pigbench.data import dataset, manifest
from pigbench.data.dataset import Dataset
from pigbench.errors import UserError
from pigbench.support import files
from pigbench.support.extras import required
from pigbench.support.lock import only_writer

_KIND = "dataset"
_STATE = ".cache"  # folder beside the files in which the library records what it has fetched


def push(data: Dataset, repository: str, *, private: bool = False) -> str:
    """Upload a data set and its card to a repository, created if need be; returns its address.

    Raises UserError if the hub rejects them.
    """
    own = [f"{record.name}/{name}" for record in data.manifest.shards for name in record.files]
    with _explaining(f"{repository} cannot be pushed to") as hub:
        api = hub.HfApi()
        api.create_repo(repository, repo_type=_KIND, private=private, exist_ok=True)
        commit = api.upload_folder(
            repo_id=repository,
            repo_type=_KIND,
            folder_path=data.folder,
            allow_patterns=[manifest.FILE_NAME, "README.md", *own],
            commit_message=f"{data.spec.environment}, {data.spec.policy}",
        )
    return str(commit.repo_url)


def pull(repository: str, folder: Path, *, revision: str | None = None) -> Dataset:
    """Fetch the data set of a repository into `folder`, and verify every byte.

    Raises UserError if there is none, if the folder contains something else, or if a file differs
    from the manifest.
    """
    if not (folder / _STATE).exists():
        files.require_new_folder(folder)
    with _explaining(f"{repository} cannot be pulled") as hub:
        api = hub.HfApi()
        api.dataset_info(repository, revision=revision)  # before a folder is made for it
        with only_writer(folder):
            api.snapshot_download(repository, repo_type=_KIND, revision=revision, local_dir=folder)
    problems = dataset.verify(folder)
    if problems:
        raise UserError(f"{repository} has no complete data set: {problems[0]}")
    return dataset.load(folder)


@contextlib.contextmanager
def _explaining(complaint: str) -> Iterator[Any]:
    """The hub's library; its errors become UserError."""
    hub, errors = required("huggingface_hub", "huggingface_hub.errors", extra="share")
    try:
        yield hub
    # The first is the web client's own, raised without a connection, for example.
    except (errors.HTTPError, errors.HFValidationError, OSError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise UserError(f"{complaint}: {reason}") from None
