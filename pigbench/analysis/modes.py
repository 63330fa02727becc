"""Contact modes, told from observations alone."""

from collections.abc import Mapping

import numpy as np

from pigbench.agents.representations import is_position
from pigbench.envs.contact import HOLDING_DISTANCE, feels
from pigbench.envs.observation import POSITION_SCALE

FREE, TOUCHING, HOLDING = "free", "touching", "holding"
MODES = FREE, TOUCHING, HOLDING


def contact_modes(observations: np.ndarray, layout: Mapping[str, slice]) -> np.ndarray:
    """The mode of each observation, (N, o) to (N,) strings of `MODES`.

    The pad feels no force (free), or it does with a cube around the pinch point (holding) or
    without (touching).
    """
    contact = observations[:, layout["gripper_contact"]][:, 0]
    pinch = observations[:, layout["effector_pos"]] / POSITION_SCALE
    cubes = [observations[:, part] for term, part in layout.items() if is_position(term)]
    held = feels(contact, pinch, np.stack(cubes, axis=1) / POSITION_SCALE, within=HOLDING_DISTANCE)
    return np.select([held.any(axis=-1), contact > 0], [HOLDING, TOUCHING], FREE)
