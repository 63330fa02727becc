"""A data set's card, read by the hub's own library."""

import re

import numpy as np
import pytest

from pigbench import cli
from pigbench.data import dataset
from pigbench.sharing import data as sharing


@pytest.fixture
def text(data) -> str:
    cli.run(["data", "card", str(data), "--license", "cc-by-4.0"])
    return (data / "README.md").read_text()


def test_the_hub_reads_the_header(text):
    hub = pytest.importorskip("huggingface_hub")
    header = hub.DatasetCard(text, ignore_metadata_errors=False).data
    assert header.license == "cc-by-4.0"
    assert header.pretty_name == "cube-single, play"
    assert header.task_categories == ["reinforcement-learning", "robotics"]
    assert header.size_categories == ["n<1K"]
    assert "cube-single" in header.tags


def test_the_card_tells_what_the_manifest_does(data, text):
    loaded = dataset.load(data)
    for fact in (
        "- policy: play",
        "simulated in pigbench's reimplementation",
        "- physics: profile exact, engine mujoco",
        "- seed: 3",
        "- split train: rows 20, episodes 5",
        "- split val: rows 4, episodes 1",
        "- versions: mujoco 1.0, jax 2.0, pigbench 3.0",
        f"- manifest's SHA-256: {loaded.digest}",
        "| `cube_0_pos` | 6 to 8 | centre of cube 0",
    ):
        assert fact in text
    assert dataset.verify(data) == []


def test_the_card_of_imported_data_claims_no_simulation(imported):
    cli.run(["data", "card", str(imported)])
    text = (imported / "README.md").read_text()
    assert "imported into pigbench from files made elsewhere" in text
    assert "- imported from: arm.csv SHA-256 ab" in text
    for claim in ("simulated", "engine", "seed:", "versions", "origin"):
        assert claim not in text


def test_the_lines_load_the_data(data, text, monkeypatch):
    (usage,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(data)
    names: dict[str, np.ndarray] = {}
    exec(usage, names)
    first = dataset.load(data).split("train")
    for field in ("observations", "actions", "terminals"):
        np.testing.assert_array_equal(names[field], first.shards(field)[0])


@pytest.mark.parametrize(
    ("rows", "category"),
    [
        (999, "n<1K"),
        (1000, "1K<n<10K"),
        (200_200, "100K<n<1M"),
        (10**8, "100M<n<1B"),
        (10**9, "n>1B"),
    ],
)
def test_sizes_are_the_hubs(rows, category):
    assert sharing._category(rows) == category
