"""The names of methods, in the order of tables, with a line on each: known without JAX.

What makes a method of a name is in `registry`.
"""

from collections.abc import Mapping
from types import MappingProxyType

_SUMMARIES = {
    "gcivl": "goal-conditioned implicit value learning with an advantage-weighted actor",
    "eik-gcivl": "GCIVL with the Eikonal residual: the value's gradient has norm 1",
    "hjb-gcivl": "GCIVL with the HJB residual: the value rises by 1 along observed motion",
    "qrl": "quasimetric RL: the largest distances with no step longer than 1",
    "eik-qrl": "QRL with the Eikonal constraint: the distance's gradient has norm 1 at most",
    "hjb-qrl": "QRL with the HJB constraint: the distance falls by 1 along observed motion",
    "gcbc": "goal-conditioned behaviour cloning",
    "gciql": "goal-conditioned implicit Q-learning with a DDPG+BC actor",
    "crl": "contrastive RL: a critic that tells a pair's own future from that of others",
    "hiql": "one implicit value, and a policy of subgoals in its representation above another",
    "sharsa": "the best of a flow's subgoals by a SARSA critic, followed by a flow clone",
    "dsharsa": "SHARSA whose low level takes the best of its flow's actions by its own critic",
    "h-flow-gcivl": "SHARSA's high level over gcivl on joints and contacts",
    "pi-h-flow-eik-gcivl": "SHARSA's high level over eik-gcivl on joints and contacts",
    "pi-h-flow-hjb-gcivl": "SHARSA's high level over hjb-gcivl on joints and contacts",
    "h-flow-qrl": "SHARSA's high level over qrl on joints and contacts",
    "pi-h-flow-eik-qrl": "SHARSA's high level over eik-qrl on joints and contacts",
    "pi-h-flow-hjb-qrl": "SHARSA's high level over hjb-qrl on joints and contacts",
}


def names() -> tuple[str, ...]:
    """The names of all methods; those of plugins come last, in order of registration."""
    return tuple(_SUMMARIES)


def summaries() -> Mapping[str, str]:
    """A line on each method, by name."""
    return MappingProxyType(_SUMMARIES)


def add(name: str, summary: str) -> None:
    """Makes the name of a registered method known; one that is known keeps its line."""
    _SUMMARIES.setdefault(name, summary)
