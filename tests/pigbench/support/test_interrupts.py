"""Signals at a command's worst moment: while a compiled program calls back into Python."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pigbench.data import dataset
from pigbench.support import files

# A program that calls back for ever, as a long rollout does.
ROLLOUT = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # also where tests ignore it, as by "&"
import time, jax, jax.numpy as jnp
from pigbench.support import interrupts
from pigbench.support.host_calls import host_call
def simulate(x):
    print("simulating", flush=True)
    sum(range(100_000))
    return x
def program(x):
    step = lambda x: CALL
    return jax.lax.while_loop(lambda x: x < 1, step, x)
with interrupts.leaving_at_once(lambda: "interrupted"):
    jax.block_until_ready(jax.jit(program)(0.0))
"""

ROLLOUTS = {
    "host call": ROLLOUT.replace("CALL", "host_call('simulate', simulate, x, x)"),
    "callback": ROLLOUT.replace("CALL", "jax.pure_callback(simulate, x, x)"),
}

# The main thread hears nothing while it is in C.
DEAF = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
import ctypes
from pigbench.support import interrupts
with interrupts.leaving_at_once(lambda: "interrupted"):
    print("waiting", flush=True)
    ctypes.CDLL(None).sem_wait((ctypes.c_long * 8)())
"""

IGNORING = """
import os, signal
from pigbench.support import interrupts
signal.signal(signal.SIGINT, signal.SIG_IGN)
with interrupts.leaving_at_once(lambda: "interrupted"):
    os.kill(os.getpid(), signal.SIGINT)
print("done")
"""

UNDOING = """
import sys, time
from pathlib import Path
from pigbench.support import files, interrupts
with interrupts.leaving_at_once(lambda: "interrupted"):
    with files.replacing_file(Path(sys.argv[1])) as file:
        file.write(b"half")
        print("writing", flush=True)
        time.sleep(600)
"""

SLOW = """
import contextlib, time
from pigbench.support import interrupts
with interrupts.leaving_at_once(lambda: "interrupted"):
    try:
        print("waiting", flush=True)
        time.sleep(600)
    finally:
        time.sleep(0.2)
        print("undoing", flush=True)
        with contextlib.suppress(KeyboardInterrupt):
            time.sleep(600)
        sum(range(100_000))
"""


def start(code: str, *arguments: Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-P", "-c", code, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("code", [*ROLLOUTS.values(), DEAF], ids=[*ROLLOUTS, "deaf"])
def test_a_process_ends_with_one_line_and_the_signals_status(code, number):
    process = start(code)
    assert process.stdout is not None
    process.stdout.readline()
    process.send_signal(number)
    _, error = process.communicate(timeout=60)
    assert (process.returncode, error) == (128 + number, "interrupted\n")


def test_what_was_being_written_is_undone(tmp_path):
    (tmp_path / "old").write_text("whole")
    process = start(UNDOING, tmp_path / "old")
    assert process.stdout is not None
    process.stdout.readline()
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    assert os.listdir(tmp_path) == ["old"]
    assert (tmp_path / "old").read_text() == "whole"


def test_a_signal_that_comes_twice_is_one_line_too():
    process = start(SLOW)
    assert process.stdout is not None
    for _ in range(2):
        process.stdout.readline()
        process.send_signal(signal.SIGTERM)
    _, error = process.communicate(timeout=60)
    assert (process.returncode, error) == (128 + signal.SIGTERM, "interrupted\n")


def test_an_ignored_signal_stays_ignored():
    output, error = start(IGNORING).communicate(timeout=60)
    assert (output, error) == ("done\n", "")


def test_data_is_whole_when_generation_is_interrupted(tmp_path):
    command = [sys.executable, "-P", "-m", "pigbench", "generate", "cube-single"]
    sizes = ["--episodes", "1000", "--episodes-per-shard", "2", "--episode-length", "11"]
    process = subprocess.Popen(
        [*command, *sizes, "--out", tmp_path], stderr=subprocess.PIPE, text=True
    )
    while len(list(tmp_path.glob("train-*"))) < 2:
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 143
    assert error.endswith("interrupted; run the same command again to go on\n")
    assert all(problem.endswith("is missing") for problem in dataset.verify(tmp_path))
    # A process that is left at once leaves its lock, which nobody holds, but no torn file.
    assert {path.name for path in tmp_path.glob(".*")} <= {files.LOCK}
