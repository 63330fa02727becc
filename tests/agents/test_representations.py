import numpy as np
import pytest

from pigbench.agents.representations import Representation
from pigbench.errors import UserError

SIZES = {
    "joint_pos": 6,
    "joint_vel": 6,
    "effector_pos": 3,
    "effector_yaw": 2,
    "gripper_opening": 1,
    "gripper_contact": 1,
    "cube_0_pos": 3,
    "cube_0_quat": 4,
    "cube_0_yaw": 2,
}
STOPS = np.cumsum(list(SIZES.values())).tolist()
LAYOUT = {
    name: slice(stop - size, stop) for (name, size), stop in zip(SIZES.items(), STOPS, strict=True)
}


@pytest.mark.parametrize(
    ("name", "kept"),
    [
        ("full", [*range(28)]),
        ("joints_contacts", [*range(12), 17, 18]),
        ("proprio", [*range(19)]),
    ],
)
def test_coordinates_kept_of_ogbenchs_single_cube(name, kept):
    represent = Representation(name, LAYOUT)
    observations = np.arange(2 * 28).reshape(2, 28)
    np.testing.assert_array_equal(represent(observations), observations[:, kept])
    assert represent.size == len(kept)


def test_its_layout_finds_the_terms_again():
    represent = Representation("joints_contacts", LAYOUT)
    observations = np.arange(28)
    assert list(represent.layout) == [
        "joint_pos",
        "joint_vel",
        "gripper_opening",
        "gripper_contact",
    ]
    for term, part in represent.layout.items():
        np.testing.assert_array_equal(represent(observations)[part], observations[LAYOUT[term]])


def test_what_cannot_be_kept_is_refused():
    with pytest.raises(UserError, match="'joints_contact': did you mean 'joints_contacts'"):
        Representation("joints_contact", LAYOUT)
    with pytest.raises(UserError, match="keeps no term of the observation, whose terms are cube_0"):
        Representation("proprio", {"cube_0_pos": slice(0, 3)})
