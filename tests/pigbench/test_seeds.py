"""Seeds: what is one, and which key it gives, whatever JAX is set to."""

import jax
import numpy as np
import pytest

from pigbench import cli, seeds
from pigbench.errors import UserError
from pigbench.evaluation.settings import Evaluation
from pigbench.suite import spec

NONE = (-1, 2**32, 2**40)  # modulo 2^32, two of them are 2^32 - 1 and 0
COMMANDS = {
    "generate": ["generate", "cube-single", "--out", "{out}", "--seed"],
    "train": ["train", "gcivl", "--data", "{out}", "--out", "{out}", "--seed"],
    "train seeds": ["train", "gcivl", "--data", "{out}", "--out", "{out}", "--seeds", "0"],
    "train evaluation": [
        *("train", "gcivl", "--data", "{out}", "--out", "{out}", "--evaluation.seed")
    ],
    "evaluate": ["evaluate", "{out}", "--seed"],
    "render": ["render", "cube-single", "--out", "{out}.png", "--seed"],
    "analyze": ["analyze", "{out}", "--data", "{out}", "--seed"],
    "subgoals": ["subgoals", "{out}", "--data", "{out}", "--seed"],
    "table": ["table", "{out}", "--bootstrap-seed"],
    "parity": ["parity", "--seed"],
    "parity data": ["parity", "data", "--seed"],
    "toy": ["toy", "--out", "{out}", "--seed"],
}


@pytest.mark.parametrize("seed", NONE)
@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_commands_refuse_other_numbers_before_they_write(command, seed, tmp_path):
    arguments = [word.format(out=tmp_path / "out") for word in command]
    with pytest.raises(UserError, match=f"seed is {seed}: it must be from 0 to 4294967295"):
        cli.parse([*arguments, str(seed)])
    assert not list(tmp_path.iterdir())


def test_consecutive_seeds_stay_within(tmp_path):
    with pytest.raises(UserError, match="seed is 4294967299"):
        cli.parse(["toy", "--out", str(tmp_path / "toy"), "--seed", str(2**32 - 1)])
    with pytest.raises(UserError, match="seed is 4294967314"):
        cli.run(["parity", "--seed", str(2**32 - 1)])


def test_suites_and_evaluations_refuse_them(tmp_path):
    suite = spec.READY.joinpath("cpu-flat.toml").read_text()
    assert "seeds = [" in suite
    path = tmp_path / "suite.toml"
    path.write_text(suite.replace("seeds = [", f"seeds = [{2**32}, "))
    with pytest.raises(UserError, match="seed is 4294967296"):
        spec.read(path)
    with pytest.raises(UserError, match="seed is -1"):
        Evaluation(seed=-1)


@pytest.mark.parametrize("seed", [0, 1, 2**31, 2**32 - 1])
def test_keys_are_threefrys_own(seed):
    with jax.default_prng_impl("rbg"):
        key = seeds.key(seed)
    # Threefry's key is the seed's high and low word.
    np.testing.assert_array_equal(jax.random.key_data(key), [0, seed])
    assert str(jax.random.key_impl(key)) == "threefry2x32"


def test_help_shows_the_default(capsys):
    with pytest.raises(SystemExit):
        cli.parse(["generate", "--help"])
    assert "--seed INT" in capsys.readouterr().out
