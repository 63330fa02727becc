"""How OpenGL is reached without a screen."""

import ctypes.util
import os

from pigbench.errors import UserError

LIBRARIES = {"egl": "EGL", "osmesa": "OSMesa"}
"""Value of MUJOCO_GL -> the library that it takes, in order of preference."""

PACKAGES = "EGL (on Debian: apt-get install libegl1 libgl1-mesa-dri) or OSMesa (libosmesa6)"
"""What to install where neither is there."""


def is_installed(name: str) -> bool:
    """Is the library there that MUJOCO_GL = `name` takes?"""
    return ctypes.util.find_library(LIBRARIES[name]) is not None


def check_choice() -> None:
    """Raises UserError if MUJOCO_GL asks for what is not there: MuJoCo would not be imported."""
    name = os.environ.get("MUJOCO_GL", "").lower().strip()
    if name in LIBRARIES and not is_installed(name):
        raise UserError(
            f"MUJOCO_GL is {name}, which is not installed: unset it, or install {PACKAGES}"
        )
