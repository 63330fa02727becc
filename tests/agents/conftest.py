import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import agents
from pigbench.agents import Batch, Statistics, Subgoals, ValueGoals
from pigbench.layout import Layout, Space

OBSERVATION_SIZE, ACTION_SIZE = 4, 2
SIZES = ("actor_hidden_sizes", "value_hidden_sizes")
SPACE = Space(Layout.of({"joint_pos": 3, "cube_0_pos": 1}), ACTION_SIZE)


@pytest.fixture
def float64():
    with jax.enable_x64(True):
        yield


@pytest.fixture(scope="session")
def build():
    """`build(name, **fields)`: a method's agent with one small layer, and other fields as given."""

    def build(name, **fields):
        kind = type(agents.get(name).config)
        small = {field: (16,) for field in SIZES if hasattr(kind, field)}
        return agents.build(
            name,
            kind(**small | fields),
            SPACE,
            statistics=Statistics.standard(OBSERVATION_SIZE),
        )

    return build


@pytest.fixture
def init():
    """`init(agent, seed)`: fresh parameters, in double precision where that is on."""

    def init(agent, seed=0):
        params = jax.jit(agent.init)(jax.random.key(seed))
        return jax.tree.map(lambda leaf: leaf.astype(jnp.result_type(float)), params)

    return init


@pytest.fixture
def moved():
    """`moved(agent, params, case, other)`: the networks whose gradients differ between two cases.

    A case is target parameters and a batch.
    """

    def moved(agent, params, case, other):
        @jax.jit
        def gradients(targets, batch):
            return jax.grad(agent.loss, has_aux=True)(params, targets, batch, jax.random.key(0))[0]

        changes = jax.tree.map(
            lambda left, right: jnp.abs(left - right).max(), gradients(*case), gradients(*other)
        )
        return {name for name, part in changes.items() if max(jax.tree.leaves(part)) > 1e-5}

    return moved


@pytest.fixture
def batch():
    """Eight random transitions; the first two are at their value goals.

    Subgoals lie up to three steps on; the first three are the value goals themselves.
    """
    rng = np.random.default_rng(0)
    observations = rng.normal(size=(8, OBSERVATION_SIZE))
    value_goals = rng.normal(size=(8, OBSERVATION_SIZE))
    value_goals[:2] = observations[:2]
    states = rng.normal(size=(4, 8, OBSERVATION_SIZE))
    states[0, :3] = value_goals[:3]
    subgoals = Subgoals(
        value_subgoals=states[0],
        value_steps=np.array([0, 0, 2, 3, 3, 1, 3, 3], np.int32),
        value_success=np.array([1.0] * 3 + [0.0] * 5),
        actor_subgoals=states[1],
        low_actor_goals=states[3],
        low_for_value=ValueGoals(
            np.where(np.arange(8)[:, None] == 4, observations, states[2]),
            (np.arange(8) == 4).astype(float),
        ),
    )
    return Batch(
        observations=observations,
        actions=rng.uniform(-1, 1, size=(8, ACTION_SIZE)),
        next_observations=observations + 0.3 * rng.normal(size=observations.shape),
        actor_goals=rng.normal(size=(8, OBSERVATION_SIZE)),
        for_value=ValueGoals(value_goals, np.array([1.0, 1.0] + [0.0] * 6)),
        subgoals=subgoals,
    )
