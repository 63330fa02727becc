"""The names of methods in the order of tables, with a one-line summary each, without JAX.

`registry` holds the methods themselves.
"""

from collections.abc import Mapping
from types import MappingProxyType

_SUMMARIES = {
    "gcivl": "goal-conditioned implicit value learning with an advantage-weighted actor",
    "eik-gcivl": "GCIVL with the Eikonal residual: the value's gradient has norm 1",
    "hjb-gcivl": "GCIVL with the HJB residual: the value rises by 1 along observed motion",
    "qrl": "quasimetric RL: the largest distances for which no step is longer than 1",
    "eik-qrl": "QRL with the Eikonal constraint: the distance's gradient has norm at most 1",
    "hjb-qrl": "QRL with the HJB constraint: the distance falls by 1 along observed motion",
    "gcbc": "goal-conditioned behaviour cloning",
    "gciql": "goal-conditioned implicit Q-learning with a DDPG+BC actor",
    "crl": "contrastive RL: a critic that tells a pair's own future from those of other pairs",
    "hiql": "hierarchical implicit Q-learning: one value, and policies of subgoals and of actions",
    "sharsa": "a SARSA critic picks the best of a flow's subgoals, and a flow clone follows it",
    "dsharsa": "SHARSA whose low level picks the best of its flow's actions by its own critic",
    "h-flow-gcivl": "SHARSA's high level over gcivl on joints and contacts",
    "pi-h-flow-eik-gcivl": "SHARSA's high level over eik-gcivl on joints and contacts",
    "pi-h-flow-hjb-gcivl": "SHARSA's high level over hjb-gcivl on joints and contacts",
    "h-flow-qrl": "SHARSA's high level over qrl on joints and contacts",
    "pi-h-flow-eik-qrl": "SHARSA's high level over eik-qrl on joints and contacts",
    "pi-h-flow-hjb-qrl": "SHARSA's high level over hjb-qrl on joints and contacts",
}


def names() -> tuple[str, ...]:
    """The names of all methods; plugins come last, in order of registration."""
    return tuple(_SUMMARIES)


def summaries() -> Mapping[str, str]:
    """The one-line summary of each method, by name."""
    return MappingProxyType(_SUMMARIES)


def add(name: str, summary: str) -> None:
    """Add the summary of a registered method; a name that is already known keeps its summary."""
    _SUMMARIES.setdefault(name, summary)
