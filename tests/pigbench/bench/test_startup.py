import subprocess
import sys

import pytest

from pigbench.bench import startup
from pigbench.errors import UserError

# What a look at files and tables must not import: each takes a second or more.
HEAVY = ("jax", "brax", "mujoco.mjx", "flax")
LIGHT = {
    "data info": ("pigbench.commands.data", HEAVY),
    "list": ("pigbench.commands.listing", HEAVY),
    "table": ("pigbench.commands.report", ("brax", "mujoco.mjx")),
    "suite status": ("pigbench.commands.suite_status", ("brax", "mujoco.mjx")),
}


@pytest.mark.parametrize(("module", "heavy"), LIGHT.values(), ids=LIGHT)
def test_looking_needs_no_simulator(module, heavy):
    code = f"import sys, {module}; print([name for name in {heavy} if name in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"


def test_a_commands_processor_time_is_measured():
    assert 0.01 < startup.seconds(["--help"]) < 5
    with pytest.raises(UserError, match=r"pigbench nonsense failed: .*unknown command"):
        startup.seconds(["nonsense"])
