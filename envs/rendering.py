"""Rendering of simulation states, also on machines without a display."""

# mujoco's compiled modules have no types.
# pyright: reportAttributeAccessIssue=false

import importlib
from typing import Any

import mujoco
import numpy as np
from jaxtyping import Float, UInt8

from pigbench import opengl
from pigbench.envs import appearance
from pigbench.errors import UserError


class Renderer:
    """Renders scenes of `num_cubes` cubes at `width` by `height` pixels; a context manager.

    Raises `UserError` if rendering does not work on this machine.
    """

    def __init__(
        self, num_cubes: int, *, width: int = 640, height: int = 480, shadows: bool = True
    ) -> None:
        model = appearance.build(num_cubes, width=width, height=height)
        self._data = mujoco.MjData(model)
        self._canvas = Canvas(model, width=width, height=height, shadows=shadows)

    def __enter__(self) -> "Renderer":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Release its resources."""
        self._canvas.close()

    def draw(
        self,
        qpos: Float[np.ndarray, "nq"],
        goal: Float[np.ndarray, "cube 3"] | None = None,
    ) -> UInt8[np.ndarray, "height width 3"]:
        """An image of the state; translucent cubes mark a `goal` in metres."""
        self._data.qpos[:] = qpos
        self._data.mocap_pos[:] = appearance.NOWHERE if goal is None else goal
        mujoco.mj_forward(self._canvas.model, self._data)
        return self._canvas.draw(self._data)


class Canvas:
    """Renders a MuJoCo model from its free camera; `UserError` if that does not work here.

    `mujoco.Renderer` would do the same, but its OpenGL library is fixed when MuJoCo is imported.
    """

    def __init__(
        self, model: mujoco.MjModel, *, width: int, height: int, shadows: bool = True
    ) -> None:
        self.model = model
        self._camera, self._option = mujoco.MjvCamera(), mujoco.MjvOption()
        mujoco.mjv_defaultFreeCamera(model, self._camera)
        self._scene = mujoco.MjvScene(model, maxgeom=1000)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
        self._frame = mujoco.MjrRect(0, 0, width, height)
        self._opengl = _opengl(width, height)
        try:
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except mujoco.FatalError as error:
            raise UserError(
                f"OpenGL cannot draw pictures of {width} x {height} pixels here ({error}): choose "
                "smaller ones"
            ) from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)

    def draw(self, data: mujoco.MjData) -> UInt8[np.ndarray, "height width 3"]:
        """An image of a state on which `mj_forward` has been called."""
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(
            self.model, data, self._option, None, self._camera, everything, self._scene
        )
        picture = np.empty((self._frame.height, self._frame.width, 3), np.uint8)
        self._opengl.make_current()
        mujoco.mjr_render(self._frame, self._scene, self._context)
        mujoco.mjr_readPixels(picture, None, self._frame, self._context)
        return picture[::-1]  # OpenGL's rows start at the bottom

    def close(self) -> None:
        """Release OpenGL's resources."""
        self._opengl.make_current()
        self._context.free()
        self._opengl.free()


def _opengl(width: int, height: int) -> Any:
    """An OpenGL context from MuJoCo, made current."""
    name = opengl.choose()
    try:
        context = importlib.import_module(f"mujoco.{name}").GLContext(width, height)
        context.make_current()
    # The type of the exception depends on the driver.
    except Exception as error:
        raise UserError(
            f"nothing can be drawn here with OpenGL by {name} ({error}): set MUJOCO_GL to another "
            f"of {', '.join(opengl.LIBRARIES)}"
        ) from error
    return context
