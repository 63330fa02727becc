import importlib.metadata
import json
import subprocess
from pathlib import Path

import jax
import mujoco

from pigbench import settings
from pigbench.provenance import package_versions, provenance
from pigbench.support import files


def test_versions_are_the_installed_ones():
    assert package_versions() == {
        "pigbench": importlib.metadata.version("pigbench"),
        "jax": jax.__version__,
        "mujoco": mujoco.__version__,
    }


def test_provenance_is_json_and_names_the_commit_and_the_command(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.argv", ["/bin/pigbench", "train", "gcivl", "--out", "a folder"])
    found = provenance(dataset=tmp_path, dataset_digest="ab")
    files.write_json(tmp_path / "provenance.json", found)
    assert json.loads((tmp_path / "provenance.json").read_text()) == found
    assert found["numerics"] == settings.in_force()
    assert found["command"] == "pigbench train gcivl --out 'a folder'"
    root = Path(__file__).parents[2]
    assert (root / "pyproject.toml").exists()
    if (root / ".git").exists():
        command = ["git", "-C", str(root), "rev-parse", "HEAD"]
        commit = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
        assert found["commit"].removesuffix("-dirty") == commit
