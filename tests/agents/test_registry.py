import dataclasses

import jax
import jax.numpy as jnp
import pytest

from pigbench import agents
from pigbench.agents.presets import PRESETS
from pigbench.errors import UserError
from pigbench.layout import Layout, Space

SPACE = Space(Layout.of({"joint_pos": 4}), 2)


def test_the_paper_preset_is_the_papers_table():
    for name in ("gcivl", "eik-gcivl", "hjb-gcivl"):
        paper = dataclasses.asdict(agents.get(name).preset("paper"))
        assert paper.pop("regularizer").get("weight") == (None if name == "gcivl" else 1.0)
        assert paper == {
            "learning_rate": 3e-4,
            "batch_size": 1024,
            "actor_hidden_sizes": (1024,) * 4,
            "value_hidden_sizes": (1024,) * 4,
            "expectile": 0.9,
            "temperature": 10.0,
            "layer_norm": True,
            "actor_layer_norm": False,
            "goals": "state",
            "rewards": "-1/0",
            "discount": 0.999,
            "target_rate": 0.005,
            "value_goals": {"current": 0.2, "future": 0.5, "random": 0.3, "geometric": True},
            "actor_goals": {"current": 0.0, "future": 1.0, "random": 0.0, "geometric": False},
        }


def test_a_preset_changes_fields_that_methods_have():
    configs = [agents.get(name).config for name in agents.names()]
    lows = [config.low for config in configs if hasattr(config, "low")]
    for preset in PRESETS.values():
        assert all(any(hasattr(config, field) for config in configs) for field in preset)
        assert all(any(hasattr(low, field) for low in lows) for field in preset.get("low", {}))


@pytest.mark.parametrize("preset", ["paper", "cpu"])
def test_the_three_gcivls_differ_in_their_regularizer_alone(preset):
    plain, eikonal, hjb = (
        agents.get(name).preset(preset) for name in ("gcivl", "eik-gcivl", "hjb-gcivl")
    )
    assert [c.regularizer.kind for c in (plain, eikonal, hjb)] == ["none", "eikonal", "hjb"]
    assert plain == dataclasses.replace(eikonal, regularizer=plain.regularizer)
    assert plain == dataclasses.replace(hjb, regularizer=plain.regularizer)


def test_a_hierarchy_over_a_method_has_that_methods_configuration():
    """The paper's table for the high level; a preset shrinks the networks of both."""
    paper, cpu = (agents.get("pi-h-flow-hjb-gcivl").preset(name) for name in ("paper", "cpu"))
    assert paper.low == agents.get("hjb-gcivl").config
    assert (paper.subgoal_steps, paper.flow_steps, paper.candidates) == (25, 10, 32)
    assert paper.low_level_representation == "joints_contacts"
    assert paper.low_discount == pytest.approx(0.96)
    assert cpu.low == dataclasses.replace(
        paper.low,
        actor_hidden_sizes=(256,) * 3,
        value_hidden_sizes=(256,) * 3,
        actor_layer_norm=True,
        rewards="0/1",
    )
    assert (cpu.batch_size, cpu.learning_rate) == (256, 1e-3)
    assert (cpu.discount, cpu.target_rate) == (0.99, 0.03)
    assert (cpu.candidates, cpu.low_level_representation) == (4, "joints_contacts")
    assert (paper.average_rate, cpu.average_rate) == (1, 1e-3)


@pytest.mark.parametrize("preset", ["paper", "cpu"])
def test_every_method_builds_and_acts(preset):
    def act(key):
        states = jnp.zeros(4)
        return agent.act(agent.init(key), states, states, key)

    for name in agents.names():
        method = agents.get(name)
        agent = agents.build(
            name,
            method.preset(preset),
            SPACE,
            statistics=agents.Statistics.standard(4),
        )
        assert jax.eval_shape(act, jax.random.key(0)).shape == (2,)
        assert "\n" not in method.summary


def test_unknown_names_offer_the_nearest():
    with pytest.raises(UserError, match=r"unknown method 'hjb-gcvl': did you mean 'hjb-gcivl'"):
        agents.get("hjb-gcvl")
    with pytest.raises(UserError, match=r"unknown preset 'papr': did you mean 'paper'"):
        agents.get("gcivl").preset("papr")


def test_a_name_is_registered_once():
    with pytest.raises(UserError, match="'gcivl' is already registered"):
        agents.register(agents.get("gcivl"))


@pytest.mark.parametrize("wrapped", [False, True])
def test_a_configuration_must_declare_the_classes_of_its_parts(wrapped):
    """Else a run that was trained with it could not be read back."""

    @dataclasses.dataclass(frozen=True)
    class Other:
        weight: float = 1.0

    config = agents.GCIVLConfig(regularizer=Other())
    method = agents.Method("mine", agents.GCIVL, config, "one's own")
    if wrapped:
        method = agents.hierarchy("mine", agents.GCIVL, config, summary="one's own")
    with pytest.raises(UserError, match="regularizer is of class Other, which GCIVLConfig does"):
        agents.register(method)
    assert "mine" not in agents.names()


def test_a_registered_method_is_found(monkeypatch):
    method = dataclasses.replace(agents.get("gcivl"), name="mine")
    monkeypatch.setattr(agents.registry, "_METHODS", {})
    monkeypatch.setattr(agents.catalogue, "_SUMMARIES", dict(agents.summaries()))
    agents.register(method)
    assert agents.names()[-1] == "mine"
    assert agents.summaries()["mine"] == method.summary
    assert agents.get("mine") is method


def test_a_configuration_of_another_agent_is_refused():
    with pytest.raises(UserError, match="'gcivl' is configured by GCIVLConfig, not by AgentConfig"):
        agents.build("gcivl", agents.AgentConfig(), SPACE)


@pytest.mark.parametrize(
    "name", [name for name in agents.names() if name not in {"gcbc", "crl", "sharsa", "dsharsa"}]
)
def test_state_values_know_the_goal_and_the_state(name):
    """One number a pair; in a quasimetric 0 at the goal itself, and never above."""
    agent = agents.build(
        name,
        agents.get(name).preset("cpu"),
        SPACE,
        statistics=agents.Statistics.standard(4),
    )
    params = jax.jit(agent.init)(jax.random.key(0))
    states, goals = jax.random.normal(jax.random.key(1), (2, 7, 4))
    value = jax.jit(jax.vmap(agent.state_value, (None, 0, 0)))
    values = value(params, states, goals)
    assert values.shape == (7,)
    assert len(set(values.tolist())) == 7
    if "qrl" in name:
        assert values.max() < 0
        assert jnp.abs(value(params, goals, goals)).max() == 0


def test_methods_without_a_state_value_say_so():
    agent = agents.build("gcbc", agents.get("gcbc").config, SPACE)
    with pytest.raises(UserError, match="learns no value"):
        agent.state_value({}, jnp.zeros(4), jnp.zeros(4))


def test_every_name_of_the_catalogue_is_a_method():
    assert tuple(agents.registry._METHODS) == agents.names()
    assert {name: agents.get(name).summary for name in agents.names()} == agents.summaries()
