import numpy as np
import pytest

from pigbench.agents.representations import Representation
from pigbench.agents.statistics import Statistics
from pigbench.errors import UserError
from pigbench.layout import Layout

LAYOUT = Layout.of(
    {
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
)


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
    observations = np.arange(2.0 * 28).reshape(2, 28)
    np.testing.assert_array_equal(represent(observations), observations[:, kept])
    assert represent.size == len(kept)


def test_its_layout_finds_the_terms_again():
    represent = Representation("joints_contacts", LAYOUT)
    observations = np.arange(28.0)
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
        Representation("proprio", Layout.of({"cube_0_pos": 3}))


def test_standardized_it_has_mean_0_and_deviation_1_in_the_data_and_can_be_undone():
    data = np.random.default_rng(0).normal(3, 5, (1000, 28)).astype(np.float32)
    represent = Representation("joints_contacts", LAYOUT, Statistics.of(data))
    x = np.asarray(represent(data))
    np.testing.assert_allclose(x.mean(axis=0), 0, atol=1e-5)
    np.testing.assert_allclose(x.std(axis=0), 1, rtol=1e-5)
    kept = data[:, [*range(12), 17, 18]]
    np.testing.assert_allclose(represent.restore(x), kept, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(represent.units, kept.std(axis=0), rtol=1e-5)
    for found, expected in zip(represent.statistics(None), (0, 1), strict=True):
        np.testing.assert_array_equal(found, np.full(14, expected))


def test_as_it_is_it_has_the_datas_statistics():
    data = Statistics(np.arange(28.0), 1 + np.arange(28.0))
    represent = Representation("joints_contacts", LAYOUT)
    mean, deviation = represent.statistics(data)
    assert mean.tolist() == [*range(12), 17, 18]
    assert deviation.tolist() == [*range(1, 13), 18, 19]
    assert represent.units == 1
    assert represent.statistics(None) is None
