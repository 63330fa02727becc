"""An exported policy acts where pigbench is not, as it did here, to the bit."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import jax
import numpy as np
import pytest

from pigbench import cli, seeds, xla
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.runs.restore import restore
from pigbench.sharing import policy
from pigbench.support import files

safetensors = pytest.importorskip("safetensors.numpy")
pytest.importorskip("flatbuffers")

METHOD = "pi-h-flow-hjb-gcivl"  # draws from its key, standardises, and normalises layers
TRAIN = [
    *("--preset", "cpu", "--steps", "3", "--evaluate-every", "2", "--evaluation.episodes", "1"),
    *("--agent.value-hidden-sizes", "16", "--agent.actor-hidden-sizes", "16", "16"),
    *("--agent.low.value-hidden-sizes", "16", "--agent.low.actor-hidden-sizes", "32", "32"),
    *("--agent.batch-size", "8", "--keep", "all", "--goals", "cubes"),
]
BATCHES = (1, 33)

ELSEWHERE = """
import sys
sys.path.append({site!r})
try:
    import pigbench
except ImportError:
    pass
else:
    raise SystemExit("pigbench is here")
import numpy
for number, (observations, goals) in enumerate(numpy.load("inputs.npz").values()):
{usage}
    numpy.save(f"actions-{{number}}", actions)
"""


@pytest.fixture(scope="module")
def run(played, short_episodes, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("policy") / "run"
    with short_episodes():
        cli.run(["train", METHOD, "--data", str(played), "--out", str(folder), *TRAIN])
    return folder


@pytest.fixture(scope="module")
def exported(run) -> Path:
    folder = run.parent / "policy"
    cli.run(["export", str(run), "--out", str(folder), "--checkpoint", "2"])
    return folder


def test_the_readmes_lines_act_alike_to_the_bit_without_pigbench(run, exported):
    pairs = [jax.random.normal(jax.random.key(size), (2, size, 28)) for size in BATCHES]
    np.savez(exported.parent / "inputs.npz", *map(np.asarray, pairs))
    (usage,) = re.findall(r"```python\n(.*?)```", (exported / "README.md").read_text(), re.DOTALL)
    usage = re.sub(r'"(\S+\.(safetensors|jax_export))"', r'"policy/\1"', usage)
    script = ELSEWHERE.format(
        site=str(Path(np.__file__).parents[1]),
        usage="\n".join(f"    {line}" for line in usage.splitlines()),
    )
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", script],
        cwd=exported.parent,
        # As in these tests, which hardly optimise; what pigbench adds is not there.
        env={"JAX_PLATFORMS": "cpu", "XLA_FLAGS": os.environ["XLA_FLAGS"].removesuffix(xla.CURE)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    trained = restore(run, checkpoint="2")
    act = jax.jit(policy.batched(trained.agent))
    for number, pair in enumerate(pairs):
        there = np.load(exported.parent / f"actions-{number}.npy")
        here = np.asarray(act(trained.state.acting, *pair, jax.random.key(0)))
        assert here.std() > 1e-3
        np.testing.assert_array_equal(there, here)


def test_the_program_takes_the_same_keys_whatever_jax_is_set_to(run):
    trained = restore(run, checkpoint="2")
    with jax.default_prng_impl("rbg"):
        program = policy.serialize(trained.agent, trained.state.acting)
    assert jax.export.deserialize(bytearray(program)).in_avals[-1].dtype == seeds.key(0).dtype


def test_parameters_are_those_of_the_checkpoint_under_their_paths(run, exported):
    stored = safetensors.load_file(exported / policy.PARAMETERS_FILE)
    params = restore(run, checkpoint="2").state.acting
    assert len(stored) == len(jax.tree.leaves(params))
    np.testing.assert_array_equal(
        stored["low_policy/params/MLP_0/Dense_1/kernel"],
        params["low_policy"]["params"]["MLP_0"]["Dense_1"]["kernel"],
    )


def test_the_configuration_tells_what_it_is_and_no_place_of_this_machine(run, exported):
    about = json.loads((exported / policy.CONFIG_FILE).read_text())
    assert about["step"] == 2
    assert about["config"] == files.read_sealed(run / "config.json")
    assert about["observation"][-1] == {"name": "cube_0_yaw", "start": 26, "stop": 28}
    assert len(about["statistics"]["mean"]) == 28
    rows = [row for row in episodes.read(run / "episodes.csv") if row.step == 2]
    assert about["success"]["episodes"] == len(rows) == 5
    program = (exported / policy.ACT_FILE).read_bytes()
    assert b".py" not in program
    text = (exported / "README.md").read_text()
    assert text.startswith('---\nlicense: "apache-2.0"\n')
    assert "| `cube_0_pos` | 19 to 21 | centre of cube 0" in text


def test_a_policy_replaces_a_policy_and_nothing_else(run, exported, tmp_path):
    cli.run(["export", str(run), "--out", str(exported), "--checkpoint", "2"])
    (tmp_path / "thesis.tex").write_text("all of it")
    with pytest.raises(UserError, match="holds no policy; choose another"):
        cli.run(["export", str(run), "--out", str(tmp_path)])
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_what_is_not_installed_is_named(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "safetensors.numpy", None)
    with pytest.raises(UserError, match=r"needs the package safetensors.*pigbench\[share\]"):
        cli.run(["export", str(run), "--out", str(tmp_path / "new")])
    assert not (tmp_path / "new").exists()
