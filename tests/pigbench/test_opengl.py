"""What MUJOCO_GL asks for is there, or one line says what to install."""

import ctypes.util
import os
import subprocess
import sys

import pytest

from pigbench import cli, opengl
from pigbench.errors import UserError


@pytest.fixture
def nothing_installed(monkeypatch):
    monkeypatch.setattr(ctypes.util, "find_library", lambda _: None)


# What MUJOCO_GL is -> what is said where no library is installed.
WRONG = {
    "egl": "MUJOCO_GL is egl, which is not installed",
    " OSMesa ": "MUJOCO_GL is osmesa, which is not installed",
    "EGLL": "unknown value of MUJOCO_GL 'egll': did you mean 'egl'",
    "off": "MUJOCO_GL is off: unset it to draw",
    "": "nothing can be drawn here: install EGL",
    "on": "nothing can be drawn here: install EGL",
}
DRAWING = {
    "picture": "render cube-single --out {}/x.png",
    "film": "render {} --out {}/x.mp4",
    "film of data": "data render nothing --out {}/x.mp4",
}


@pytest.mark.parametrize("command", DRAWING.values(), ids=DRAWING)
@pytest.mark.parametrize(("name", "says"), WRONG.items())
def test_what_cannot_be_drawn_is_said_before_the_work(
    command, name, says, tmp_path, monkeypatch, nothing_installed
):
    monkeypatch.setenv("MUJOCO_GL", name)
    with pytest.raises(UserError, match=says):
        cli.run(command.format(tmp_path, tmp_path).split())


@pytest.mark.parametrize("name", WRONG)
def test_what_does_not_draw_goes_on(name, monkeypatch, nothing_installed, capsys):
    monkeypatch.setenv("MUJOCO_GL", name)
    cli.run(["list", "envs"])
    assert "cube-single" in capsys.readouterr().out


def test_mujoco_is_imported_whatever_is_asked_for():
    """In a process of its own, with a value at which MuJoCo by itself is not imported."""
    environment = os.environ | {"MUJOCO_GL": "nonsense"}
    plain = [sys.executable, "-P", "-c", "import mujoco"]
    assert subprocess.run(plain, env=environment, capture_output=True).returncode != 0
    ours = [sys.executable, "-P", "-m", "pigbench", "list", "envs"]
    done = subprocess.run(ours, env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_what_is_asked_for_is_taken_in_any_case(monkeypatch):
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: name)
    for asked in ("EGL", "egl ", "OSMesa", "glfw"):
        monkeypatch.setenv("MUJOCO_GL", asked)
        assert opengl.choose() == asked.lower().strip()


def test_the_library_of_each_choice_is_looked_for(monkeypatch):
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: name if name == "EGL" else None)
    assert [opengl.is_installed(name) for name in opengl.LIBRARIES] == [True, False]
