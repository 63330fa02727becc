"""Four devices of a host come to what one comes to, but for rounding."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from pigbench.errors import UserError
from pigbench.training.layout import Layout

TOLERANCE = 1e-5
"""Of parameters after 20 updates, which move them by about a hundredth: sums in another order."""


@pytest.mark.parametrize(
    ("seeds", "how", "layout"),
    [(4, "", [4, 1]), (1, "data-parallel", [1, 4]), (2, "data-parallel", [2, 2]), (3, "", [3, 1])],
)
def test_it_comes_to_the_same(seeds, how, layout):
    script = str(Path(__file__).with_name("on_devices.py"))
    flags = f"--xla_force_host_platform_device_count=4 {os.environ.get('XLA_FLAGS', '')}"
    ended = subprocess.run(
        [sys.executable, script, str(seeds), how],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "XLA_FLAGS": flags, "JAX_PLATFORMS": "cpu"},
    )
    assert ended.returncode == 0, ended.stderr
    found = json.loads(ended.stdout.splitlines()[-1])
    assert found["devices"] == 4
    assert found["layout"] == layout
    assert found["moved"] > 100 * TOLERANCE
    assert found["apart"] < TOLERANCE


def test_one_device_shares_no_batch():
    assert Layout.over_all(seeds=3, batch_size=8, data_parallel=False) == Layout()
    with pytest.raises(UserError, match="data_parallel shares batches of 8 among devices"):
        Layout.over_all(seeds=1, batch_size=8, data_parallel=True)
