"""What networks see of a goal, and where goals come from."""

import dataclasses

import gymnasium
import jax
import numpy as np
import ogbench  # noqa: F401  registers its environments
import pytest
from ogbench.relabel_utils import add_oracle_reps

from pigbench import agents, envs
from pigbench.agents import registry
from pigbench.agents.goals import GOALS, GoalMixture
from pigbench.agents.representations import Representation
from pigbench.errors import UserError
from pigbench.layout import Layout, Space

SMALL = {"actor_hidden_sizes": (16,), "value_hidden_sizes": (16,)}
QUASIMETRICS = ("qrl", "eik-qrl", "hjb-qrl")
ROBOT, CUBE = slice(0, 3), slice(3, 4)  # of the observations of these tests


def with_other_goals(batch, part):
    """The batch whose goals have other numbers in `part` of them."""

    def other(goals):
        return np.concatenate(
            [goals[:, slot] + (1 if slot == part else 0) for slot in (ROBOT, CUBE)], axis=1
        )

    return batch.replace(
        for_value=batch.for_value.replace(states=other(batch.value_goals)),
        actor_goals=other(batch.actor_goals),
    )


@pytest.mark.parametrize("name", [name for name in agents.names() if name not in QUASIMETRICS])
def test_told_of_cubes_alone_a_method_does_not_mind_the_robots_part_of_a_goal(build, batch, name):
    config = agents.get(name).config
    changed = registry._override(config, {"goals": "cubes", **SMALL, "low": SMALL})
    fields = {field.name: getattr(changed, field.name) for field in dataclasses.fields(changed)}
    agent = build(name, **fields)
    assert agent.goal_size == 1
    params = jax.jit(agent.init)(jax.random.key(0))
    targets = {network: params[network] for network in agent.target_networks}

    @jax.jit
    def loss_and_actions(batch):
        loss, _ = agent.loss(params, targets, batch, jax.random.key(1))
        act = jax.vmap(agent.act, (None, 0, 0, None))
        actions = act(params, batch.observations, batch.actor_goals, jax.random.key(2))
        return loss, actions

    loss, actions = loss_and_actions(batch)
    same_loss, same_actions = loss_and_actions(with_other_goals(batch, ROBOT))
    assert same_loss == loss
    np.testing.assert_array_equal(same_actions, actions)
    other_loss, other_actions = loss_and_actions(with_other_goals(batch, CUBE))
    assert other_loss != loss
    assert np.any(other_actions != actions)


@pytest.mark.parametrize("name", ["gcivl", "gciql", "hiql"])
def test_told_of_cubes_alone_a_value_does_not_mind_the_robots_part_of_a_goal(build, batch, name):
    agent = build(name, goals="cubes")
    params = jax.jit(agent.init)(jax.random.key(0))
    value = jax.vmap(agent.state_value, (None, 0, 0))
    values, same, other = (
        np.asarray(value(params, goals.observations, goals.value_goals))
        for goals in (batch, with_other_goals(batch, ROBOT), with_other_goals(batch, CUBE))
    )
    np.testing.assert_array_equal(same, values)
    assert np.all(other != values)


@pytest.mark.parametrize("name", QUASIMETRICS)
def test_a_quasimetric_refuses(name):
    with pytest.raises(UserError, match="goals is 'cubes': a quasimetric measures distances"):
        dataclasses.replace(agents.get(name).config, goals="cubes")


def test_a_quasimetric_may_be_the_low_level_of_a_hierarchy_told_of_cubes(build):
    agent = build("h-flow-qrl", goals="cubes")
    assert (agent.goal_size, agent.low.goal_size) == (1, agent.represent.size)


def test_unknown_goals_are_refused():
    with pytest.raises(UserError, match="unknown goals 'cube': did you mean 'cubes'"):
        agents.AgentConfig(goals="cube")


@pytest.mark.parametrize("name", ["cube-single", "cube-double"])
def test_cubes_are_ogbenchs_oracle_representation(name):
    """Of the same states: those of its environment, and those that its loader makes of rows."""
    theirs = gymnasium.make(f"{name}-v0", use_oracle_rep=True)
    ours = envs.make(name)
    represent = Representation("cubes", ours.layout, table=GOALS)
    theirs.reset(seed=0)
    rows: dict[str, list[np.ndarray]] = {"observations": [], "qpos": []}
    for action in np.random.default_rng(0).uniform(-1, 1, (3, 5)):
        observation, *_ = theirs.step(action)
        rows["observations"].append(observation)
        rows["qpos"].append(theirs.unwrapped._data.qpos.copy())
    arrays = {field: np.array(values, np.float32) for field, values in rows.items()}
    add_oracle_reps(name, theirs, arrays)
    goals = np.asarray(represent(arrays["observations"]))
    np.testing.assert_allclose(goals, arrays["oracle_reps"], atol=1e-5)
    last = theirs.unwrapped.compute_oracle_observation()
    np.testing.assert_allclose(goals[-1], last, atol=1e-5)


def test_a_tasks_goal_is_that_of_ogbenchs_environment():
    """In both where the task's cube is to be, after two random steps that leave it there."""
    env = envs.make("cube-single")
    represent = Representation("cubes", env.layout, table=GOALS)
    reset = jax.jit(env.reset_task)
    theirs = gymnasium.make("cube-single-v0", use_oracle_rep=True)
    for number, task in enumerate(env.spec.tasks, start=1):
        position = 10 * (np.array(task.goal_xyz[0]) - (0.425, 0, 0))
        _, info = theirs.reset(seed=0, options={"task_id": number})
        np.testing.assert_allclose(info["goal"], position, atol=1e-3)
        ours = represent(reset(jax.random.key(0), number).info["goal"])
        np.testing.assert_allclose(ours, info["goal"], atol=1e-3)


def test_an_agent_that_does_not_know_other_goals_refuses_them():
    class StatesAlone(agents.Agent):
        init = loss = act = None

    space = Space(Layout.of({"cube_0_pos": 1}), 1)
    StatesAlone(agents.AgentConfig(), space)
    with pytest.raises(UserError, match="goals is 'cubes': StatesAlone supports only state"):
        StatesAlone(agents.AgentConfig(goals="cubes"), space)


@pytest.mark.parametrize(
    "shares", [(0.5, 0.5, 0.5), (0.2, 0.3, 0.4), (1.5, -0.5, 0.0), (float("nan"), 0.5, 0.5)]
)
def test_a_mixture_must_be_a_distribution(shares):
    with pytest.raises(UserError, match="must be three probabilities that sum to 1"):
        GoalMixture(*shares, geometric=True)


def test_rounding_does_not_reject_a_mixture():
    GoalMixture(current=0.1, future=0.2, random=0.7, geometric=True)
