import numpy as np
import pytest

from pigbench.layout import GROUPS, Layout

LAYOUT = Layout.of(
    {
        "joint_pos": 6,
        "joint_vel": 6,
        "effector_pos": 3,
        "gripper_contact": 1,
        "cube_0_pos": 3,
        "cube_0_quat": 4,
        "cube_10_pos": 3,
    }
)


def test_a_term_is_found_where_the_terms_before_it_end():
    assert LAYOUT.size == 26
    assert dict(LAYOUT) == {
        "joint_pos": slice(0, 6),
        "joint_vel": slice(6, 12),
        "effector_pos": slice(12, 15),
        "gripper_contact": slice(15, 16),
        "cube_0_pos": slice(16, 19),
        "cube_0_quat": slice(19, 23),
        "cube_10_pos": slice(23, 26),
    }
    assert "cube_0_pos" in LAYOUT
    assert "cube_1_pos" not in LAYOUT
    with pytest.raises(KeyError):
        LAYOUT["cube_1_pos"]


BY_HAND = {
    "all": [*range(26)],
    "robot": [*range(16)],
    "joints_contacts": [*range(12), 15],
    "objects": [*range(16, 26)],
    "object_positions": [16, 17, 18, 23, 24, 25],
    "velocities": [*range(6, 12)],
}


@pytest.mark.parametrize("group", GROUPS)
def test_the_coordinates_of_groups_by_hand(group):
    parts, coordinates = LAYOUT.group(group), BY_HAND[group]
    assert np.concatenate([np.arange(26)[part] for part in parts.values()]).tolist() == coordinates
    assert all(LAYOUT[name] == part for name, part in parts.items())


def test_robot_and_objects_are_all_there_is():
    assert LAYOUT.group("robot") | LAYOUT.group("objects") == LAYOUT.group("all") == dict(LAYOUT)
    assert Layout.of({"joint_pos": 6}).group("objects") == {}


def test_a_subset_has_the_layouts_order_and_slices_of_its_own():
    kept = LAYOUT.subset(["cube_0_pos", "joint_vel"])
    assert kept.terms == (("joint_vel", 6), ("cube_0_pos", 3))
    assert dict(kept) == {"joint_vel": slice(0, 6), "cube_0_pos": slice(6, 9)}
    assert LAYOUT.subset(LAYOUT) == LAYOUT


def test_equal_layouts_have_equal_terms_in_equal_order():
    one, other = ("joint_pos", 6), ("joint_vel", 6)
    assert Layout((one, other)) == Layout.of(dict([one, other]))
    assert hash(Layout((one, other))) == hash(Layout.of(dict([one, other])))
    assert Layout((one, other)) != Layout((other, one))


def test_there_may_be_no_terms():
    nothing = Layout.of({})
    assert (nothing.size, len(nothing), dict(nothing)) == (0, 0, {})
