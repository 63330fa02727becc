"""A device that is not there: one line of what computes; what does not compute goes on."""

import os
import subprocess
import sys

ABSENT = "cuda" if not os.path.exists("/dev/nvidia0") else "tpu"

# In one process: JAX takes seconds to import, and its device is chosen once.
TRY = """
import shlex, sys
from pigbench import cli
for command in sys.argv[1:]:
    sys.argv = ["pigbench", *shlex.split(command)]
    try:
        cli.main()
    except SystemExit as stop:
        if stop.code:
            print(stop.code, "at", command, file=sys.stderr)
"""

COMPUTING = [
    "generate cube-single --out {}/x",
    "data import x.npz --environment cube-single --out {}/x",
    "train gcivl --data {data} --out {}/x",
    "evaluate {run}",
    "render cube-single --out {}/x.png",
    "parity --json {}/x",
    "bench train gcivl",
    "bench scale --out {}/x.png",
    "bench memory",
    "toy --out {}/x",
    "suite cpu-flat --out {}/x",
]
READING = ["list envs", "list methods", "table {run}", "plot {run} --out {run}/x.png"]


def test_computing_says_one_line_and_reading_goes_on(tmp_path, make_run, data):
    run = make_run(tmp_path / "run", {0: [[1]]}).path
    empty = tmp_path / "empty"
    empty.mkdir()
    commands = [command.format(empty, run=run, data=data) for command in COMPUTING]
    commands += [command.format(run=run) for command in READING]
    done = subprocess.run(
        [sys.executable, "-P", "-c", TRY, *commands],
        env=os.environ | {"JAX_PLATFORMS": ABSENT},
        capture_output=True,
        text=True,
    )
    said = [line for line in done.stderr.splitlines() if not line.startswith("2 at ")]
    refused = [line for line in done.stderr.splitlines() if line.startswith("2 at ")]
    assert refused == [f"2 at {command}" for command in commands[: len(COMPUTING)]], done.stderr
    for line in said:
        assert line.startswith(f"pigbench: JAX cannot run with JAX_PLATFORMS='{ABSENT}'")
    assert "cube-single" in done.stdout
    assert not list(empty.iterdir())
