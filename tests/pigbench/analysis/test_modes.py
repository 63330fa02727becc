import numpy as np
import pytest

from pigbench.analysis.modes import contact_modes
from pigbench.envs.terms import layout

LAYOUT = layout(2)


def observation(*, contact: float, pinch: tuple, cubes: tuple) -> np.ndarray:
    """Positions in metres, as scaled in an observation; offsets do not matter to distances."""
    values = np.zeros(LAYOUT.size, np.float32)
    values[LAYOUT["gripper_contact"]] = contact
    values[LAYOUT["effector_pos"]] = 10 * np.array(pinch)
    for index, cube in enumerate(cubes):
        values[LAYOUT[f"cube_{index}_pos"]] = 10 * np.array(cube)
    return values


NEAR, AWAY = (0.1, 0.2, 0.035), (0.3, 0.2, 0.02)


@pytest.mark.parametrize(
    ("contact", "cubes", "mode"),
    [
        (0.0, (AWAY, AWAY), "free"),
        (0.0, (NEAR, AWAY), "free"),  # fingers around a cube, but open
        (0.9, (AWAY, AWAY), "touching"),
        (0.9, (AWAY, NEAR), "holding"),
        (0.9, ((0.1, 0.2, 0.055), AWAY), "touching"),  # 2.5 cm below: pushing on its top
    ],
)
def test_modes_follow_from_contact_and_the_nearest_cube(contact, cubes, mode):
    states = observation(contact=contact, pinch=(0.1, 0.2, 0.03), cubes=cubes)[None]
    assert contact_modes(states, LAYOUT).tolist() == [mode]
