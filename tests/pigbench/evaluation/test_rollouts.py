"""Evaluation against what its episodes must do."""

import re
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import agents
from pigbench.errors import UserError
from pigbench.evaluation import rollouts
from pigbench.evaluation.measures import MEASURES
from pigbench.evaluation.rollouts import as_episodes, make_evaluator
from pigbench.evaluation.settings import Evaluation


class Still:
    """An agent that asks for `params` as its action, whatever it sees."""

    def act(self, params, observation, goal, key):
        return params


def test_success_and_length_are_those_of_the_episodes(env):
    evaluation = Evaluation(episodes=3)
    outcome = make_evaluator(env, Still(), evaluation)(jnp.zeros(5), print)
    np.testing.assert_array_equal(outcome["success"], [[True] * 3, [False] * 3])
    np.testing.assert_array_equal(outcome["length"], [[1] * 3, [6] * 3])
    assert not outcome["diverged"].any()
    rows = as_episodes(outcome, env, evaluation, step=7)
    assert [
        (row.step, row.task, row.task_name, row.episode, row.measures["length"]) for row in rows
    ] == [
        *((7, 1, "solved", episode, 1) for episode in range(3)),
        *((7, 2, "far", episode, 6) for episode in range(3)),
    ]


def test_a_diverged_simulation_counts_as_failed(env):
    outcome = make_evaluator(env, Still(), Evaluation(episodes=1))(jnp.full(5, jnp.nan), print)
    assert outcome["diverged"].all()
    assert not outcome["success"].any()
    np.testing.assert_array_equal(outcome["length"], 1)


def test_episodes_depend_on_seed_task_and_number_alone(env, drawn):
    few = make_evaluator(env, drawn, Evaluation(episodes=1, seed=4))
    many = make_evaluator(env, drawn, Evaluation(episodes=3, seed=4))
    ones, others = few(None, print), many(None, print)
    for name in MEASURES:
        np.testing.assert_allclose(ones[name], others[name][:, :1], rtol=1e-6)


def test_restored_parameters_compile_nothing_twice(env, monkeypatch, caplog):
    """They are committed to a device, as those of a first evaluation are not."""
    monkeypatch.setattr(rollouts, "_CHUNK", 2)
    params = jax.device_put(jnp.zeros(5), jax.devices()[0])
    assert params.committed
    with jax.log_compiles():
        make_evaluator(env, Still(), Evaluation(episodes=1))(params, print)
    compiled = re.findall(r"Finished XLA compilation of jit\((\w+)\)", caplog.text)
    assert compiled.count("advance") == 1


@pytest.mark.parametrize(
    ("limit", "reports", "success"), [(130, [50, 100, 130], False), (250, [50, 100, 150], True)]
)
def test_a_rollout_goes_on_until_all_have_ended_but_not_beyond_the_limit(limit, reports, success):
    def after(time):
        return SimpleNamespace(time=time, states=SimpleNamespace(done=np.array([True, time > 140])))

    reported = []
    ended = rollouts.finish(
        after(0), lambda rollout, steps: after(rollout.time + steps), limit, reported.append
    )
    assert reported == reports
    assert ended.states.done.all() == success


def test_no_episodes_are_refused():
    with pytest.raises(UserError, match="at least 1"):
        Evaluation(episodes=0)


def test_every_method_can_be_evaluated(env):
    agent = agents.build("gcivl", agents.get("gcivl").preset("cpu"), env.space)
    params = agents.create(agent, jax.random.key(0)).params
    outcome = make_evaluator(env, agent, Evaluation(episodes=1))(params, print)
    assert outcome["success"].shape == (2, 1)
