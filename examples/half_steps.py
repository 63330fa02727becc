"""A physics engine: MuJoCo in C with substeps half as long, to see what their length changes."""

from pigbench.envs import physics
from pigbench.envs.physics.mujoco import MujocoPhysics
from pigbench.envs.scene import SUBSTEPS


class HalfSteps(MujocoPhysics):
    """MuJoCo in C; a control step has twice as many substeps, of half the length."""

    name = "mujoco-half-steps"

    def __init__(self, scene):
        super().__init__(scene)
        self._model.opt.timestep /= 2

    def _advance(self, state, ctrl, active):
        return self._call(2 * SUBSTEPS, state, ctrl, active)


physics.register(HalfSteps)
