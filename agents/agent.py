"""What an agent is: a definition without state. Parameters come in and go out as pytrees."""

import abc
from collections.abc import Mapping
from typing import Any, Generic, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from pigbench.agents import directions
from pigbench.agents.batch import Batch, Sampling
from pigbench.agents.config import AgentConfig
from pigbench.agents.directions import Coordinates, Direction
from pigbench.agents.representations import GOALS, Representation
from pigbench.agents.statistics import Statistics
from pigbench.errors import UserError

Params = dict[str, Any]  # network name -> its parameters
Metrics = dict[str, jax.Array]  # "<part>/<quantity>" -> scalar

Config = TypeVar("Config", bound=AgentConfig)
T = TypeVar("T")


def combine(*parts: tuple[jax.Array, Metrics]) -> tuple[jax.Array, Metrics]:
    """The sum of the parts' losses, and the metrics of all."""
    metrics = {name: value for _, part in parts for name, value in part.items()}
    return jnp.stack([loss for loss, _ in parts]).sum(), metrics


def describe(part: str, values: jax.Array) -> Metrics:
    """Mean, least and greatest of `values`, as metrics of `part`."""
    return {
        f"{part}/mean": values.mean(),
        f"{part}/min": values.min(),
        f"{part}/max": values.max(),
    }


def add_prefix(prefix: str, entries: Mapping[str, T]) -> dict[str, T]:
    """`entries` under longer names: those of one level of a hierarchy among the other's."""
    return {prefix + name: entry for name, entry in entries.items()}


def take_prefix(prefix: str, entries: Mapping[str, T]) -> dict[str, T]:
    """What `add_prefix` was given."""
    return {
        name.removeprefix(prefix): entry
        for name, entry in entries.items()
        if name.startswith(prefix)
    }


class Agent(abc.ABC, Generic[Config]):
    """Networks, loss terms and goal mixture of one method, for one observation and action space.

    `layout` names the slices of an observation, in order: an agent that treats some coordinates
    apart finds them there by name. `statistics` are those of its observations in the data, and
    `units` tells what a unit of each coordinate is in the environment's own, (observation_size,).
    All methods are pure and work under `jit`, `vmap` and `scan`.
    """

    target_networks: tuple[str, ...] = ()
    """The networks that have a slowly averaged copy, given to `loss` as `target_params`."""

    average_rate: float = 1.0
    """The share of an update's parameters in the average that acts; at 1 the last ones act."""

    goals: tuple[str, ...] = ("state",)
    """What its networks can be told of a goal, of `GOALS`: others than states need `as_goals`."""

    def __init__(
        self,
        config: Config,
        *,
        observation_size: int,
        action_size: int,
        layout: Mapping[str, slice],
        statistics: Statistics | None = None,
        units: np.ndarray | float = 1.0,
    ) -> None:
        self.config = config
        self.observation_size = observation_size
        self.action_size = action_size
        self.layout = layout
        self.statistics = statistics
        self.units = units
        if config.goals not in self.goals:
            raise UserError(
                f"goals is {config.goals!r}: {type(self).__name__} knows {', '.join(self.goals)} "
                "alone (an agent whose loss and act pass goals to as_goals names others in `goals`)"
            )
        self._represent_goals = None  # as they are, whatever the layout names
        if config.goals != "state":
            self._represent_goals = Representation(config.goals, layout, table=GOALS)

    @property
    def goal_size(self) -> int:
        """Numbers that networks see of a goal."""
        return self._represent_goals.size if self._represent_goals else self.observation_size

    def as_goals(self, states: jax.Array) -> jax.Array:
        """What networks see of goals, which are states elsewhere: (..., o) to (..., goal_size)."""
        return self._represent_goals(states) if self._represent_goals else states

    def direction(self, name: str) -> Direction:
        """The direction of motion of that name in this agent's coordinates."""
        return directions.make(name, Coordinates(self.layout, self.statistics, self.units))

    @property
    def motion_in(self) -> str:
        """What motion is measured in where a residual looks along it, of `DIRECTIONS`."""
        return "own"

    def motion(self, states: jax.Array, next_states: jax.Array, *, epsilon: float) -> jax.Array:
        """u of a step, in observations, as this agent's residuals take it: (B, o) to (B, o)."""
        return self.direction(self.motion_in)(states, next_states, epsilon=epsilon)

    @property
    def sampling(self) -> Sampling:
        """How this agent's batches are to be drawn."""
        return Sampling(
            value_goals=self.config.value_goals,
            actor_goals=self.config.actor_goals,
            discount=self.config.discount,
        )

    @abc.abstractmethod
    def init(self, key: jax.Array) -> Params:
        """Fresh parameters of every network that the optimiser trains."""

    @abc.abstractmethod
    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: jax.Array
    ) -> tuple[jax.Array, Metrics]:
        """The scalar to minimise in `params`, and scalar metrics."""

    def state_values(self, params: Params, observations: jax.Array, goals: jax.Array) -> jax.Array:
        """V(s, g): (B, o) and (B, o) to (B,).

        Raises `UserError` if the method learns no such value.
        """
        raise UserError("this method learns no value V(s, g): choose a run of another")

    @abc.abstractmethod
    def act(
        self, params: Params, observations: jax.Array, goals: jax.Array, key: jax.Array
    ) -> jax.Array:
        """The evaluation policy: (B, o) and (B, o) to actions (B, a) in [-1, 1]."""
