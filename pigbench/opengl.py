"""The choice of an OpenGL library that draws without a screen."""

import contextlib
import ctypes.util
import importlib
import os
from collections.abc import Iterator

from pigbench.errors import UserError, unknown_name

LIBRARIES = {"egl": "EGL", "osmesa": "OSMesa"}
"""Value of MUJOCO_GL -> the library that it needs, in order of preference."""

PACKAGES = "EGL (on Debian: apt-get install libegl1 libgl1-mesa-dri) or OSMesa (libosmesa6)"
"""What to install if neither is present."""

_VARIABLE = "MUJOCO_GL"
_SCREEN = "glfw"
_ANY = "", "on", "enable", "enabled", "true", "1"
_NONE = "off", "disable", "disabled", "false", "0"


def is_installed(name: str) -> bool:
    """Whether the library that MUJOCO_GL = `name` needs is installed."""
    return ctypes.util.find_library(LIBRARIES[name]) is not None


def choose() -> str:
    """The way to draw, by MuJoCo's name: that of MUJOCO_GL, or else the first that is installed.

    Raises UserError if it is not available.
    """
    name = _asked()
    if name in _NONE:
        raise UserError(f"{_VARIABLE} is {name}: unset it to draw")
    if name in _ANY:
        installed = next(filter(is_installed, LIBRARIES), None)
        if installed is None:
            raise UserError(f"nothing can be drawn here: install {PACKAGES}")
        return installed
    if name == _SCREEN:
        return name
    if name not in LIBRARIES:
        raise unknown_name(f"value of {_VARIABLE}", name, [*LIBRARIES, _SCREEN])
    if not is_installed(name):
        raise UserError(
            f"{_VARIABLE} is {name}, which is not installed: unset it, or install {PACKAGES}"
        )
    return name


def spare_mujoco() -> None:
    """Import MuJoCo without the setting of MUJOCO_GL if that would make the import fail.

    The setting matters only for drawing, which calls `choose`.
    """
    try:
        if _asked() not in (*_ANY, *_NONE):
            choose()
    except UserError:
        with _without_choice():
            importlib.import_module("mujoco")


def _asked() -> str:
    return os.environ.get(_VARIABLE, "").lower().strip()


@contextlib.contextmanager
def _without_choice() -> Iterator[None]:
    asked = os.environ.pop(_VARIABLE)
    try:
        yield
    finally:
        os.environ[_VARIABLE] = asked
