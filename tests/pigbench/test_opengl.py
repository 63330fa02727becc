"""What MUJOCO_GL asks for is there, or one line says what to install."""

import ctypes.util

import pytest

from pigbench import cli, opengl
from pigbench.errors import UserError


@pytest.mark.parametrize("name", ["egl", "osmesa", " OSMesa "])
def test_a_missing_library_is_named_before_anything_is_imported(monkeypatch, name):
    monkeypatch.setenv("MUJOCO_GL", name)
    monkeypatch.setattr(ctypes.util, "find_library", lambda _: None)
    with pytest.raises(UserError, match=r"MUJOCO_GL is (egl|osmesa), which is not installed"):
        cli.run(["list", "envs"])


@pytest.mark.parametrize("name", ["", "glfw", "off"])
def test_other_choices_are_mujocos_own_business(monkeypatch, name):
    monkeypatch.setenv("MUJOCO_GL", name)
    monkeypatch.setattr(ctypes.util, "find_library", lambda _: None)
    opengl.check_choice()


def test_the_library_of_each_choice_is_looked_for(monkeypatch):
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: name if name == "EGL" else None)
    assert [opengl.is_installed(name) for name in opengl.LIBRARIES] == [True, False]
