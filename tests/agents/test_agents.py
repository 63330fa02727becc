"""What every registered method must do: learn a small task, and train on from where it was."""

import dataclasses
import sys
from collections.abc import Callable
from functools import cache, partial
from typing import NamedTuple

import jax
import numpy as np
import pytest

from pigbench import agents
from pigbench.agents import AgentConfig, AWRExtraction
from pigbench.data import sampler
from pigbench.layout import Layout, Space
from pigbench.support.compare import flatten

SPACE = Space(Layout.of({"joint_pos": 2}), 2)
"""Any representation keeps the joints, so all of a point's state."""


@cache
def point_mass_rows(episodes=1500):
    """A point in the square [-5, 5]^2 that moves by its action; noisy walks to random targets."""
    rng = np.random.default_rng(0)
    states, actions, terminals = [], [], []
    for _ in range(episodes):
        state, target = rng.uniform(-5, 5, size=(2, 2))
        arrived = False
        while not arrived:
            arrived = np.abs(target - state).max() < 0.5
            action = np.clip(target - state + 0.3 * rng.normal(size=2), -1, 1)
            states.append(state)
            actions.append(action)
            terminals.append(arrived)
            state = np.clip(state + action, -5, 5)
    return sampler.Rows.create(np.float32(states), np.float32(actions), terminals)


TINY = {
    "actor_hidden_sizes": (64, 64),
    "value_hidden_sizes": (64, 64),
    "latent_size": 64,
    "subgoal_steps": 3,
}


def tiny(config):
    """The configuration, and those nested in it, with networks and horizons of the task's size."""
    fields = {field.name: getattr(config, field.name) for field in dataclasses.fields(config)}
    nested = {name: tiny(value) for name, value in fields.items() if isinstance(value, AgentConfig)}
    return dataclasses.replace(
        config, **{name: size for name, size in TINY.items() if name in fields}, **nested
    )


OPTIMIZED = {"xla_backend_optimization_level": 1, "xla_cpu_use_fusion_emitters": True}
"""Methods run long enough here to pay for better programs than other tests need."""


class Method(NamedTuple):
    """A method's state at first, and its functions, each compiled once."""

    state: agents.TrainState
    train: Callable[[agents.TrainState, int], agents.TrainState]  # for a number of updates
    act: Callable[..., jax.Array]  # of params, 100 states, their goals and a key


@cache
def build(name: str) -> Method:
    config = dataclasses.replace(
        tiny(agents.get(name).config), batch_size=128, discount=0.95, learning_rate=1e-3
    )
    rows = point_mass_rows()
    agent = agents.build(
        name,
        config,
        SPACE,
        statistics=agents.Statistics.of(rows.observations),
    )

    def update(_, state):
        keys = jax.random.split(jax.random.fold_in(jax.random.key(1), state.step))
        batch = sampler.sample(keys[0], rows, agent.sampling, config.batch_size)
        return agents.update(agent, state, batch, keys[1])[0]

    @partial(jax.jit, compiler_options=OPTIMIZED)
    def train(state, count):
        return jax.lax.fori_loop(0, count, update, state)

    @partial(jax.jit, compiler_options=OPTIMIZED)
    def act(params, states, goals, key):
        keys = jax.random.split(key, len(states))
        return jax.vmap(agent.act, (None, 0, 0, 0))(params, states, goals, keys)

    create = partial(agents.create, agent)
    return Method(create(jax.random.key(0)), train, act)


@pytest.mark.parametrize("name", agents.names())
def test_reaches_goals_of_a_point_mass(name):
    method = build(name)
    params = method.train(method.state, 1000).params
    states, goals = np.random.default_rng(2).uniform(-4.5, 4.5, size=(2, 100, 2))
    reached = np.zeros(100, bool)
    for key in jax.random.split(jax.random.key(2), 30):
        moves = np.asarray(method.act(params, states, goals, key))
        states = np.clip(states + moves, -5, 5)
        reached |= np.linalg.norm(states - goals, axis=-1) < 0.5
    assert reached.mean() >= 0.8


@pytest.mark.parametrize("name", agents.names())
def test_actions_are_bounded(name):
    method = build(name)
    states = 100 * jax.random.normal(jax.random.key(1), (100, 2))
    actions = method.act(method.state.params, states, -states, jax.random.key(2))
    assert np.all(np.abs(actions) <= 1)


@pytest.mark.parametrize("name", agents.names())
def test_trains_on_to_the_same_bits(name):
    state, train, _ = build(name)
    whole, resumed = train(state, 6), train(train(state, 3), 3)
    for left, right in zip(jax.tree.leaves(whole), jax.tree.leaves(resumed), strict=True):
        assert left.tobytes() == right.tobytes()
    assert whole.step == 6


def watched(config, reads: set[str], place: str = ""):
    """The configuration, and those nested in it, noting the dotted names of fields that are read.

    To check a value or to copy it is not to use it, and does not count.
    """

    class Watched(type(config)):
        def __getattribute__(self, field):
            reader = sys._getframe(1)
            copies_or_checks = reader.f_globals["__name__"] in {"dataclasses", "pigbench.errors"}
            if not copies_or_checks and reader.f_code.co_name not in {"__post_init__", "__eq__"}:
                reads.add(f"{place}{field}")
            return super().__getattribute__(field)

    fields = {field.name: getattr(config, field.name) for field in dataclasses.fields(config)}
    nested = {
        name: watched(value, reads, f"{place}{name}.")
        for name, value in fields.items()
        if dataclasses.is_dataclass(value) and not is_decided_above(f"{place}{name}")
    }
    return Watched(**fields | nested)


def is_decided_above(field: str) -> bool:
    """Whether a hierarchy refuses another value of this field of its low level."""
    decided = agents.FlowHierarchyConfig.decided
    return any(field == place or field.startswith(f"{place}.") for place in decided)


CONFIGS = {name: agents.get(name).config for name in agents.names()}
CONFIGS["qrl by awr"] = dataclasses.replace(CONFIGS["qrl"], actor=AWRExtraction())


@pytest.mark.parametrize("name", CONFIGS)
def test_every_field_of_a_configuration_is_read(name):
    """But for the kinds of options, which tell them apart, and what two shares leave a third."""
    reads = set()
    config = watched(tiny(CONFIGS[name]), reads)
    rows = point_mass_rows()
    statistics = agents.Statistics.of(rows.observations)
    agent = agents.build(name.split()[0], config, SPACE, statistics=statistics)

    def use(key):
        state = agents.create(agent, key)
        batch = sampler.sample(key, rows, agent.sampling, config.batch_size)
        state, _ = agents.update(agent, state, batch, key)
        return agent.act(state.acting, batch.observations[0], batch.actor_goals[0], key)

    jax.eval_shape(use, jax.random.key(0))
    fields = dict(flatten(dataclasses.asdict(config)))
    unread = {field for field in fields.keys() - reads if not is_decided_above(field)}
    assert {field for field in unread if not field.endswith((".kind", ".future"))} == set()
