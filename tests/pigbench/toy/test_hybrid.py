import jax.numpy as jnp
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from pigbench.agents.residuals import eikonal_residual, hjb_residual
from pigbench.toy.hybrid import HYBRID

FREE, HOLDING = HYBRID.fits[0]
SIDE = 21
STEP = 0.1
POSITIONS = STEP * np.arange(-10, 11)


def shortest_paths():
    """Costs to the goal by Dijkstra on a grid: free states (agent, object), then held objects."""
    free = np.arange(SIDE**2).reshape(SIDE, SIDE)
    held = SIDE**2 + np.arange(SIDE)
    edges = [
        (free[1:], free[:-1], STEP),
        (free[:-1], free[1:], STEP),
        (held[1:], held[:-1], STEP),
        (held[:-1], held[1:], STEP),
        (free.diagonal(), held, 1.0),  # the grasp, where agent and object meet
    ]
    start, end = (np.concatenate([edge[i].ravel() for edge in edges]) for i in (0, 1))
    costs = np.concatenate([np.full(edge[0].size, edge[2]) for edge in edges])
    backwards = coo_array((costs, (end, start)), shape=2 * (SIDE**2 + SIDE,)).tocsr()
    return np.split(dijkstra(backwards, indices=held[SIDE // 2]), [SIDE**2])


def test_the_cost_to_go_is_the_length_of_the_shortest_path():
    free, held = shortest_paths()
    states = np.stack(np.meshgrid(POSITIONS, POSITIONS, indexing="ij"), axis=-1).reshape(-1, 2)
    np.testing.assert_allclose(FREE.cost_to_go(states), free, atol=1e-5)
    together = np.stack([POSITIONS, POSITIONS], axis=-1)
    np.testing.assert_allclose(HOLDING.cost_to_go(together), held, atol=1e-5)


def test_optimal_motion_lowers_the_cost_as_fast_as_time_passes():
    states = np.array([[0.5, -0.3], [-0.7, 0.2], [0.1, 0.9]])
    for mode in (FREE, HOLDING):
        moved = mode.successor(states)
        gain = mode.cost_to_go(states) - mode.cost_to_go(moved)
        np.testing.assert_allclose(gain, 0.01, atol=1e-6)


def test_motion_stops_at_object_and_goal():
    np.testing.assert_allclose(FREE.successor(jnp.array([[0.304, 0.3]])), [[0.3, 0.3]])
    np.testing.assert_allclose(HOLDING.successor(jnp.array([[0.004, 0.004]])), [[0, 0]], atol=1e-9)


def test_residuals_of_the_cost_to_go_by_hand():
    """Free: HJB holds. Eikonal holds where d* is flat in x_o; elsewhere the norm is sqrt(5).

    Holding: d* = |x_a| has norm 1, but slope sqrt(1/2) along (1, 1) / sqrt(2), the joint motion.
    """
    behind = jnp.array([[0.8, 0.3], [-0.9, -0.1]])  # the object lies between agent and goal
    before = jnp.array([[0.1, 0.6], [-0.4, 0.5], [0.4, -0.5]])
    for states, norm in ((behind, 1.0), (before, 5**0.5)):
        assert_residuals(FREE, states, hjb=0.0, eikonal=(norm - 1) ** 2)
        assert_residuals(HOLDING, states, hjb=(1 - 0.5**0.5) ** 2, eikonal=0.0)


def assert_residuals(mode, states, *, hjb, eikonal):
    def value(states):
        return -mode.cost_to_go(states)

    _, found = hjb_residual(value, states, mode.successor(states), epsilon=1e-6)
    np.testing.assert_allclose(found, hjb, atol=2e-3)
    _, found = eikonal_residual(value, states, speed=1.0)
    np.testing.assert_allclose(found, eikonal, atol=1e-5)


def test_kinks_by_hand():
    states = np.array([[0.4, 0.1], [0.4, 0.3], [0.2, -0.1]])
    expected = [0.1, 0.1 / 2**0.5, 0.1]
    np.testing.assert_allclose(FREE.kink_distance(states), expected, rtol=1e-5)
    np.testing.assert_allclose(HOLDING.kink_distance(states), [0.4, 0.4, 0.2], rtol=1e-6)
