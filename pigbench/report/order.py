"""The order of names in tables and figures."""

from pigbench import agents, envs


def registered() -> tuple[str, ...]:
    """The order of registration: methods, then environments."""
    return (*agents.names(), *envs.names())
