"""Engine `mjx-warp`, for NVIDIA GPUs: MJX over NVIDIA Warp."""

# mujoco's compiled modules have no types.
# pyright: reportAttributeAccessIssue=false

import importlib.util
from typing import Any

import numpy as np
from jaxtyping import Array, Bool

from pigbench.envs.physics.mjx import MjxPhysics
from pigbench.envs.scene import Scene
from pigbench.errors import UserError

# Room for the contacts of one simulation: those of a grasp, and those of each cube with the floor,
# a wall and its neighbours. Six episodes of OGBench's play with two cubes need at most 24 of 56.
_GRASP_CONTACTS, _CUBE_CONTACTS = 32, 12
_ROWS = 3  # constraint rows per contact, and at most per equality


class MjxWarp(MjxPhysics):
    """MJX over NVIDIA Warp. Raises `UserError` if the `warp` extra is not installed."""

    name = "mjx-warp"
    implementation = "warp"

    def __init__(self, scene: Scene):
        if importlib.util.find_spec("warp") is None:
            raise UserError("engine mjx-warp needs NVIDIA Warp: pip install 'pigbench[warp]'")
        super().__init__(scene)
        from mujoco.mjx.third_party.mujoco_warp import OverflowType

        self._no_overflow = OverflowType.ITERATIONS  # the solver stopped early, as it may in C

    def _make_model(self) -> Any:
        return super()._make_model().tree_replace({"opt._impl.warn_overflow": 0})

    def _make_data(self, simulations: int) -> Any:
        model = self.scene.model
        contacts = _GRASP_CONTACTS + _CUBE_CONTACTS * self.scene.num_cubes
        return self._mjx.make_data(
            model,
            impl=self.implementation,
            naconmax=simulations * contacts,
            njmax=_ROWS * (contacts + model.neq) + int(np.sum(model.jnt_limited)),
        )

    def _overflow(self, data: Any) -> Bool[Array, ""]:
        return (data._impl.overflow & ~int(self._no_overflow)) != 0
