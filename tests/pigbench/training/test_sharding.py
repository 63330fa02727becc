"""Four devices of a host come to what one comes to, but for rounding."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from pigbench.errors import UserError
from pigbench.training.sharding import Sharding

TOLERANCE = 1e-5
"""Of parameters after 20 updates: sums in another order."""
SHARDINGS = [[4, 1], [2, 2]]
"""Devices that share seeds, and batches: of 4 seeds, and of 2 with split batches."""


def test_four_devices_train_the_parameters_that_one_trains():
    script = str(Path(__file__).with_name("on_devices.py"))
    flags = f"{os.environ.get('XLA_FLAGS', '')} --xla_force_host_platform_device_count=4"
    ended = subprocess.run(
        [sys.executable, script],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "XLA_FLAGS": flags, "JAX_PLATFORMS": "cpu"},
    )
    assert ended.returncode == 0, ended.stderr
    found = [json.loads(line) for line in ended.stdout.splitlines()]
    assert [one["sharding"] for one in found] == SHARDINGS
    for one in found:
        assert one["devices"] == 4
        assert one["apart"] < TOLERANCE < one["moved"] / 100


def test_one_device_shares_no_batch():
    assert Sharding.over_all(seeds=3, batch_size=8, data_parallel=False) == Sharding()
    with pytest.raises(UserError, match="data_parallel shares batches of 8 among devices"):
        Sharding.over_all(seeds=1, batch_size=8, data_parallel=True)
