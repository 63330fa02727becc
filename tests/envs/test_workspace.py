"""The boxes, equal to OGBench's."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from pigbench.envs import workspace


@pytest.mark.parametrize(
    ("box", "attribute"),
    [
        (workspace.PINCH, "_workspace_bounds"),
        (workspace.PINCH_START, "_arm_sampling_bounds"),
        (workspace.CUBE, "_object_sampling_bounds"),
        (workspace.CUBE, "_target_sampling_bounds"),
    ],
)
def test_bounds(ogbench_env, box, attribute):
    np.testing.assert_array_equal(
        [box.low, box.high], getattr(ogbench_env("cube-single"), attribute)
    )


def test_samples_are_uniform_in_the_box():
    box = workspace.Box((-1.0, 2.0), (1.0, 10.0))
    points = np.asarray(box.sample(jax.random.key(0), (40, 50)))
    assert points.shape == (40, 50, 2)
    for axis in range(2):
        low, width = box.low[axis], box.high[axis] - box.low[axis]
        uniform = stats.uniform(low, width)
        assert stats.kstest(points[..., axis].ravel(), uniform.cdf).pvalue > 1e-3


def test_clip():
    box = workspace.Box((0.0, 0.0), (1.0, 2.0))
    np.testing.assert_array_equal(box.clip(jnp.array([[-1.0, 1.0], [3.0, 4.0]])), [[0, 1], [1, 2]])
