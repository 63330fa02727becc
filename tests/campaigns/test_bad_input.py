"""What a user may get wrong, over every command: one line, status 2, nothing written, nothing lost.

A case is a line of a table. `make test` tries every seventh; all are tried by
`PIGBENCH_CAMPAIGN=all pytest tests/campaigns`.
"""

import hashlib
import json
import math
import os
import shlex
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pigbench import cli
from pigbench.support import files

# Folders: DATA and RUN are whole, OUT does not exist, BAD holds one torn file beside whole ones.
GENERATE = "generate cube-single --out OUT"
TRAIN = "train gcbc --data DATA --out OUT"

# Options of whole numbers, by the command that takes them; in the second table at least 1.
NUMBERS = {
    GENERATE: ["--seed", "--validation-episodes"],
    TRAIN: ["--seed", "--seeds", "--evaluation.seed", "--agent.batch-size"],
    "evaluate RUN": ["--seed"],
    "render cube-single --out OUT.png": ["--task", "--seed", "--size.width"],
    "toy --out OUT": ["--seed"],
}
COUNTS = {
    GENERATE: ["--episodes", "--episode-length", "--episodes-per-shard"],
    TRAIN: ["--steps", "--log-every", "--evaluate-every", "--evaluation.episodes"],
    "evaluate RUN": ["--episodes"],
    "analyze RUN --data DATA": ["--samples"],
    "subgoals RUN --data DATA": ["--samples"],
    "toy --out OUT": ["--seeds"],
    "suite cpu-flat --out OUT": ["--jobs"],
    "bench train gcbc": ["--turns.turns"],
    "bench scale --out OUT.png": ["--simulations", "--batch"],
    "bench memory": ["--simulations"],
    "parity": ["--episodes"],
    "parity data": ["--episodes"],
}
NO_NUMBERS = ["x", "1.5", "''", "1e3", "nan", "½"]
NO_COUNTS = ["0", "-1", "-99999999999999999999"]
NO_SEEDS = ["-1", "4294967296", "99999999999999999999"]

NAMES = [
    "generate cube-singel --out OUT",
    "generate 'cube single' --out OUT",
    f"{GENERATE} --policy ply",
    f"{GENERATE} --physics exat",
    f"{GENERATE} --engine mujco",
    "train gcivil --data DATA --out OUT",
    f"{TRAIN} --preset papr",
    f"{TRAIN} --data-parallel",
    f"{TRAIN} --engine x",
    f"{TRAIN} --goals cube",
    f"{TRAIN} --variant a/b",
    f"{TRAIN} --variant $x$",
    f"{TRAIN} --seeds 1 1",
    f"{TRAIN} --seed 3 --seeds 0 1",
    f"{TRAIN} --vectorized",
    f"{TRAIN} --goals state --agent.goals cubes",
    f"{GENERATE} --policy replan --episode-length 7",
    f"{GENERATE} --cpus-per-task 2",
    "render cube-single --out OUT.png --episodes 2",
    f"{TRAIN} --agent.discont 1",
    f"{TRAIN} --agent.actor-hidden-sizes x",
    "table RUN --show method",
    "table RUN --format html",
    "table RUN --checkpoint lst",
    "plot RUN --out OUT.png --kind curve",
    "plot RUN --out OUT.xyz",
    "plot RUN --out OUT",
    "render cube-singel --out OUT.png",
    "render cube-single --out OUT.mp4",
    "render RUN --out OUT.png",
    "render cube-single --out OUT.png --task 6",
    "render cube-single --out OUT.png --size.width 63",
    "data export DATA --out OUT.h5",
    "data export DATA --out OUT.npz --format ogbnch",
    "data export DATA --out DATA --format lerobot",
    "data export DATA --out OUT --format minari --goals cubes",
    "data import DATA --environment cube-single --out OUT --format minari",
    "data import DATA --environment cube-centre --out OUT --format log",
    "data filter DATA --out OUT",
    "data filter DATA --out OUT --criteria sucess",
    "evaluate RUN --noise -1",
    "table RUN --show noise",
    "table RUN --first-episodes 0",
    "data card OUT",
    "export RUN --out DATA",
    "export RUN --out OUT --checkpoint first",
    "evaluate RUN --checkpoint 7",
    "data render DATA --out OUT.mp4 --split tst",
    "data render DATA --out OUT.mp4 --episode 99",
    "suite cpu-flt --out OUT",
    "list env",
    "toy --out OUT --example hybird",
    "bench train gcibc",
    "trian",
    "data inof DATA",
    "generate cube-single",
    "train gcbc --data DATA",
    "train --data DATA --out OUT",
    "plot RUN",
    "table",
    "data import",
    f"{GENERATE} --what",
    f"{GENERATE} stray",
    "list envs --plugin",
    "list envs --plugin OUT.py",
    "list envs --plugin DATA",
    "data import --environment cube-single --out OUT",
    "data filter DATA --out OUT --criteria",
    "table RUN --show",
    "bench scale --out OUT.png --simulations",
    "bench scale --out OUT.png --environments",
    "bench memory --engine",
    "bench generate --physics",
    "parity data --policies",
    "bench device --out OUT --sizes.methods",
]
MISSING = [
    "data info OUT",
    "data verify OUT",
    "data filter OUT --out OUT2",
    "data export OUT --out OUT.npz",
    "data render OUT --out OUT.mp4",
    "data import OUT.npz --environment cube-single --out OUT",
    "train gcbc --data OUT --out OUT",
    "evaluate OUT",
    "evaluate DATA",
    "table OUT",
    "table DATA",
    "plot OUT --out OUT.png",
    "analyze OUT --data DATA",
    "subgoals OUT --data DATA",
    "render OUT --out OUT.mp4",
    "suite OUT.toml --out OUT",
    "suite status OUT",
    "suite status DATA",
    "data info RUN",
    "train gcbc --data RUN --out OUT",
    "train gcbc --data DATA --out DATA",
    "generate cube-single --out RUN",
]


def sealed(**content: object) -> bytes:
    """A file whose checksum is right."""
    return json.dumps(files.sealed(content)).encode()


TORN = {
    "empty": b"",
    "cut": b'{"format": 1, "spe',
    "list": b"[]",
    "null": b"null",
    "number": b"1",
    "text": b'"text"',
    "no text": b"\xff\xfe\x00",
    "deep": b"[" * 100_000,
    "deep object": b'{"a":' * 100_000,
    "no checksum": b'{"format": 1}',
    "format only": sealed(format=1),
    "nothing in it": sealed(format=1, spec={}, shards=[]),
    "wrong kinds": sealed(format=1, spec=[1], shards=3),
    "infinite": sealed(format=math.inf),
    "header": b"step,task\n",
    "row": b"step,task,task_name,episode,seed,engine,success,check\n1,2\n",
}
TORN_FILES = {
    "data/manifest.json": [
        "data info BAD/data",
        "data verify BAD/data",
        "train gcbc --data BAD/data --out OUT",
    ],
    "run/config.json": ["table BAD/run", "plot BAD/run --out OUT.png", "evaluate BAD/run"],
    "run/episodes.csv": ["table BAD/run", "plot BAD/run --out OUT.png"],
    "suite.json": ["suite status BAD"],
    "suite.toml": ["suite BAD/suite.toml --out OUT"],
    "F.npz": ["data import BAD/F.npz --environment cube-single --out OUT"],
    "plugin.py": ["list envs --plugin BAD/plugin.py"],
}
# A file of these bytes is no fault there: an empty Python file registers nothing.
HARMLESS = {("plugin.py", kind) for kind in ("empty", "list", "number", "text", "format only")} | {
    ("plugin.py", "no checksum"),
    ("plugin.py", "nothing in it"),
    ("plugin.py", "wrong kinds"),
}


def _cases() -> Iterator[tuple[str, str, bytes]]:
    """A command, and the file that it meets torn, with its content, or none."""
    for table, values in ((NUMBERS, NO_NUMBERS), (COUNTS, [*NO_NUMBERS, *NO_COUNTS])):
        for command, options in table.items():
            for option in options:
                more = NO_SEEDS if option.endswith(("--seed", "evaluation.seed")) else []
                yield from ((f"{command} {option} {value}", "", b"") for value in values + more)
    yield from ((command, "", b"") for command in NAMES + MISSING)
    for file, commands in TORN_FILES.items():
        for kind, content in TORN.items():
            if (file, kind) not in HARMLESS:
                yield from ((f"{command} # {kind}", file, content) for command in commands)


CASES = list(_cases())
CHOSEN = CASES if os.environ.get("PIGBENCH_CAMPAIGN") == "all" else CASES[::7]


@pytest.fixture(scope="session")
def place(prepared) -> Path:
    """Where all cases happen: none leaves a trace."""
    bad = prepared / "BAD"
    shutil.copytree(prepared / "DATA", bad / "data")
    shutil.copytree(prepared / "RUN", bad / "run")
    return prepared


def digest(folder: Path) -> dict[Path, str]:
    """What every file below the folder holds."""
    return {
        path: hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "folder"
        for path in folder.rglob("*")
    }


@pytest.mark.parametrize(
    ("command", "file", "content"), CHOSEN, ids=[f"{command[:70]}" for command, *_ in CHOSEN]
)
def test_one_line_and_nothing_else(command, file, content, place, monkeypatch, capsys):
    monkeypatch.chdir(place)
    whole = None
    torn = place / "BAD" / file
    if file:
        whole = torn.read_bytes() if torn.exists() else None
        torn.write_bytes(content)
    before = digest(place)
    monkeypatch.setattr(sys, "argv", ["pigbench", *shlex.split(command, comments=True)])
    try:
        with pytest.raises(SystemExit) as stop:
            cli.main()
        assert digest(place) == before
    finally:
        if file:
            torn.unlink() if whole is None else torn.write_bytes(whole)
    lines = capsys.readouterr().err.splitlines()
    (complaint,) = [line for line in lines if " %  " not in line]  # other lines are of progress
    assert stop.value.code == 2
    assert complaint.startswith("pigbench: ")
    assert len(complaint) < 1000
