"""Methods by name: which agent, with which configuration."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pigbench.agents.agent import Agent
from pigbench.agents.config import AgentConfig
from pigbench.agents.gcivl import GCIVL, GCIVLConfig
from pigbench.agents.regularizers import Regularizer
from pigbench.errors import UserError, lookup

PRESETS: Mapping[str, Mapping[str, Any]] = {
    "paper": {},
    "cpu": {
        "batch_size": 256,
        "actor_hidden_sizes": (256, 256, 256),
        "value_hidden_sizes": (256, 256, 256),
        "discount": 0.99,
    },
}
"""Presets by name: what each changes in a method's own configuration."""


@dataclass(frozen=True)
class Method:
    """A row of the registry: an agent class with the configuration that makes it this method."""

    name: str
    agent: type[Agent[Any]]
    config: AgentConfig  # the `paper` preset
    summary: str  # one line
    presets: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: PRESETS)

    def preset(self, name: str) -> AgentConfig:
        """The configuration of a preset; `UserError` if there is none of that name."""
        return replace(self.config, **lookup("preset", self.presets, name))


_METHODS: dict[str, Method] = {}


def register(method: Method) -> None:
    """Make `method` known under its name; `UserError` if the name is taken."""
    if method.name in _METHODS:
        raise UserError(f"method {method.name!r} is already registered: choose another name")
    _METHODS[method.name] = method


def names() -> tuple[str, ...]:
    """The names of all methods, in order of registration."""
    return tuple(_METHODS)


def get(name: str) -> Method:
    """The method of that name; `UserError` with the nearest name if there is none."""
    return lookup("method", _METHODS, name)


def build(
    name: str,
    config: AgentConfig,
    *,
    observation_size: int,
    action_size: int,
    layout: Mapping[str, slice],
) -> Agent[Any]:
    """The agent of method `name`; `UserError` if `config` is not of that method's kind."""
    method = get(name)
    if not isinstance(config, type(method.config)):
        raise UserError(
            f"method {name!r} is configured by {type(method.config).__name__}, "
            f"not by {type(config).__name__}"
        )
    return method.agent(
        config, observation_size=observation_size, action_size=action_size, layout=layout
    )


for _method in (
    Method(
        name="gcivl",
        agent=GCIVL,
        config=GCIVLConfig(),
        summary="goal-conditioned implicit value learning with an advantage-weighted actor",
    ),
    Method(
        name="eik-gcivl",
        agent=GCIVL,
        config=GCIVLConfig(regularizer=Regularizer("eikonal")),
        summary="GCIVL with the Eikonal residual: the value's gradient has norm 1",
    ),
    Method(
        name="hjb-gcivl",
        agent=GCIVL,
        config=GCIVLConfig(regularizer=Regularizer("hjb")),
        summary="GCIVL with the HJB residual: the value rises by 1 along observed motion",
    ),
):
    register(_method)
