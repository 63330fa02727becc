"""Methods by name, each an agent class with a configuration."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import partial
from typing import Any, get_args, get_type_hints

from pigbench.agents import catalogue
from pigbench.agents.agent import Agent
from pigbench.agents.catalogue import summaries
from pigbench.agents.config import AgentConfig, PolicyConfig
from pigbench.agents.constraints import EikonalConstraint, HJBConstraint
from pigbench.agents.crl import CRL, CRLConfig
from pigbench.agents.flow_clone import BestOfFlow, BestOfFlowConfig, FlowClone, FlowCloneConfig
from pigbench.agents.flow_hierarchy import FlowHierarchy, FlowHierarchyConfig
from pigbench.agents.gcbc import GCBC
from pigbench.agents.gciql import GCIQL, GCIQLConfig
from pigbench.agents.gcivl import GCIVL, GCIVLConfig
from pigbench.agents.hiql import HIQL, HIQLConfig
from pigbench.agents.presets import PRESETS
from pigbench.agents.qrl import QRL, QRLConfig
from pigbench.agents.regularizers import EikonalRegularizer, HJBRegularizer
from pigbench.agents.statistics import Statistics
from pigbench.errors import UserError, lookup, lookup_own
from pigbench.layout import Space
from pigbench.names import require_new


@dataclass(frozen=True)
class Method:
    """A row of the registry: an agent class and the configuration that makes it this method."""

    name: str
    agent: Callable[..., Agent[Any]]  # a class, or a `partial` of a class that combines agents
    config: AgentConfig  # the `paper` preset
    summary: str  # one line

    def preset(self, name: str, **changes: Any) -> AgentConfig:
        """The configuration of the preset called `name`, with `changes` of its fields.

        Raises `UserError` if there is no such preset.
        """
        return replace(_override(self.config, lookup("preset", PRESETS, name)), **changes)


def _override(config: Any, changes: Mapping[str, Any]) -> Any:
    """`config` with the changes to fields that it has; a mapping changes a nested configuration."""
    return replace(
        config,
        **{
            name: _override(getattr(config, name), value) if isinstance(value, Mapping) else value
            for name, value in changes.items()
            if hasattr(config, name)
        },
    )


def hierarchy(
    name: str, low: Callable[..., Agent[Any]], config: AgentConfig, *, summary: str, **fields: Any
) -> Method:
    """A flow of subgoals above the agent `low` with `config`; `fields` are the hierarchy's own."""
    return Method(
        name=name,
        agent=partial(FlowHierarchy, low=low),
        config=FlowHierarchyConfig(low=config, **fields),
        summary=summary,
    )


_METHODS: dict[str, Method] = {}


def register(method: Method) -> None:
    """Register `method` under its name.

    Raises `UserError` if the name is taken or invalid, or if a part of the configuration is of a
    class that its field does not declare: it could not be read back from a run's folder.
    """
    require_new("a method", method.name, _METHODS)
    _check_declared(method.config)
    _METHODS[method.name] = method
    catalogue.add(method.name, method.summary)


def _check_declared(config: Any) -> None:
    declared = get_type_hints(type(config))
    for field in fields(config):
        value = getattr(config, field.name)
        if not is_dataclass(value):
            continue
        if not isinstance(value, get_args(declared[field.name]) or declared[field.name]):
            own = type(value).__name__
            raise UserError(
                f"{field.name} is of class {own}, which {type(config).__name__} does not declare: "
                f"make a configuration of your own with the field `{field.name}: {own}`"
            )
        _check_declared(value)


def get(name: str) -> Method:
    """The method called `name`; `UserError` that suggests the closest name if there is none."""
    return lookup_own("method", _METHODS, name)


def build(
    name: str,
    config: AgentConfig,
    space: Space,
    *,
    statistics: Statistics | None = None,
) -> Agent[Any]:
    """The agent of method `name` for a space, such as an environment's `space`.

    `statistics` are those of the observations from which it learns.

    Raises `UserError` if `config` is not of the method's type, or if it needs missing statistics.
    """
    method = get(name)
    if not isinstance(config, type(method.config)):
        raise UserError(
            f"method {name!r} is configured by {type(method.config).__name__}, "
            f"not by {type(config).__name__}"
        )
    return method.agent(config, space, statistics=statistics)


_FLAT: Mapping[str, tuple[Callable[..., Agent[Any]], AgentConfig]] = {
    "gcivl": (GCIVL, GCIVLConfig()),
    "eik-gcivl": (GCIVL, GCIVLConfig(regularizer=EikonalRegularizer())),
    "hjb-gcivl": (GCIVL, GCIVLConfig(regularizer=HJBRegularizer())),
    "qrl": (QRL, QRLConfig()),
    "eik-qrl": (QRL, QRLConfig(constraint=EikonalConstraint())),
    "hjb-qrl": (QRL, QRLConfig(constraint=HJBConstraint())),
    "gcbc": (GCBC, PolicyConfig()),
    "gciql": (GCIQL, GCIQLConfig()),
    "crl": (CRL, CRLConfig()),
    "hiql": (HIQL, HIQLConfig()),
}

_CLONED: Mapping[str, tuple[Callable[..., Agent[Any]], AgentConfig]] = {
    "sharsa": (FlowClone, FlowCloneConfig()),
    "dsharsa": (BestOfFlow, BestOfFlowConfig()),
}
"""Hierarchies whose low level clones actions and sees everything."""

_HIERARCHICAL: Mapping[str, str] = {
    "h-flow-gcivl": "gcivl",
    "pi-h-flow-eik-gcivl": "eik-gcivl",
    "pi-h-flow-hjb-gcivl": "hjb-gcivl",
    "h-flow-qrl": "qrl",
    "pi-h-flow-eik-qrl": "eik-qrl",
    "pi-h-flow-hjb-qrl": "hjb-qrl",
}
"""Hierarchies by their low level's method."""

for _name, (_agent, _config) in _FLAT.items():
    register(Method(_name, _agent, _config, summaries()[_name]))
for _name, _low in _CLONED.items():
    register(hierarchy(_name, *_low, low_level_representation="full", summary=summaries()[_name]))
for _name, _low in _HIERARCHICAL.items():
    register(hierarchy(_name, *_FLAT[_low], summary=summaries()[_name]))
