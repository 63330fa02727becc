"""The interface of agents: stateless definitions that take and return parameters as pytrees."""

import abc
from typing import Any, Generic, TypeVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, PRNGKeyArray, PyTree, Scalar

from pigbench.agents.batch import Batch, Sampling
from pigbench.agents.config import AgentConfig, TargetConfig, ValueConfig
from pigbench.agents.constraints import Constraint
from pigbench.agents.directions import Coordinates
from pigbench.agents.goals import GOALS
from pigbench.agents.metrics import LossAndMetrics
from pigbench.agents.regularizers import NoRegularizer, Regularizer
from pigbench.agents.representations import Representation
from pigbench.agents.statistics import Statistics
from pigbench.errors import UserError
from pigbench.layout import Space
from pigbench.shapes import Array

Params = dict[str, PyTree]  # network name -> parameters

Config = TypeVar("Config", bound=AgentConfig)


class Agent(abc.ABC, Generic[Config]):
    """Networks, loss terms and goal mixture of one method, for one observation and action space.

    `act` and `state_value` work on one example, and callers map them over many; `loss` works on a
    batch, because some terms depend on all of it: CRL's classes, DDPG+BC's scale, a dual variable.
    An agent can look up coordinates in the space's `layout`. `statistics` are those of the agent's
    observations in the data, and `units` is the size of one unit of each coordinate in the
    environment's own units. All methods are pure and work under `jit`, `vmap` and `scan`.
    """

    target_networks: tuple[str, ...] = ()
    """The networks that have a slowly averaged copy, passed to `loss` as `target_params`."""

    target_rate: float = 0.005
    """The weight of new parameters in these copies; a `TargetConfig` has its own."""

    average_rate: float = 1.0
    """The weight of new parameters in the average that acts; at 1, the latest ones act."""

    supported_goals: tuple[str, ...] = ("state",)
    """Keys of `GOALS`; all but "state" require `as_goals`."""

    def __init__(
        self,
        config: Config,
        space: Space,
        *,
        statistics: Statistics | None = None,
        units: Float[np.ndarray, "observation"] | float = 1.0,
    ) -> None:
        self.config = config
        self.layout = space.layout
        self.observation_size = space.layout.size
        self.action_size = space.action_size
        self.statistics = statistics
        self.units = units
        if isinstance(config, TargetConfig):
            self.target_rate = config.target_rate
        if config.goals not in self.supported_goals:
            raise UserError(
                f"goals is {config.goals!r}: {type(self).__name__} supports only "
                f"{', '.join(self.supported_goals)} (if its loss and act pass goals to as_goals, "
                "list others in its `supported_goals`)"
            )
        self._represent_goals = None  # goals are passed on unchanged, whatever the layout
        if config.goals != "state":
            self._represent_goals = Representation(config.goals, self.layout, table=GOALS)

    @property
    def goal_size(self) -> int:
        """The length of a goal as networks see it."""
        return self._represent_goals.size if self._represent_goals else self.observation_size

    def as_goals(self, states: Float[Array, "*batch observation"]) -> Float[Array, "*batch goal"]:
        """Goals as networks see them, from goal states."""
        return self._represent_goals(states) if self._represent_goals else states

    @property
    def inputs(self) -> dict[str, Any]:
        """Zeros for the inputs of a network of s and g, from which it learns their sizes."""
        return {
            "observations": jnp.zeros(self.observation_size),
            "goals": jnp.zeros(self.goal_size),
        }

    @property
    def critic_inputs(self) -> dict[str, Any]:
        """The same of a network of s, a and g."""
        return self.inputs | {"actions": jnp.zeros(self.action_size)}

    @property
    def coordinates(self) -> Coordinates:
        """The coordinates in which it sees states."""
        return Coordinates(self.layout, self.statistics, self.units)

    @property
    def penalty(self) -> Regularizer | Constraint:
        """The regulariser or constraint that its values are trained with."""
        return NoRegularizer()

    def value_learner(self, params: Params, batch: Batch) -> "tuple[Agent[Any], Params, Batch]":
        """What learns `state_value`: an agent, its parameters, and the batch as it sees it."""
        return self, params, batch

    @property
    def sampling(self) -> Sampling:
        """How this agent wants its batches drawn; value goals are those of a `ValueConfig`."""
        config = self.config
        return Sampling(
            value_goals=config.value_goals if isinstance(config, ValueConfig) else None,
            actor_goals=config.actor_goals,
            discount=config.discount,
        )

    @abc.abstractmethod
    def init(self, key: PRNGKeyArray) -> Params:
        """Initial parameters of every network that the optimiser trains."""

    @abc.abstractmethod
    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """The scalar to minimise in `params`, and scalar metrics.

        Unlike `act` and `state_value`, it is of a batch: some losses depend on it as a whole.
        """

    def state_value(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
    ) -> Scalar:
        """V(s, g), of a state and a goal state.

        Raises `UserError` if the method learns no state value.
        """
        raise UserError("this method learns no value V(s, g): choose a run of another method")

    @abc.abstractmethod
    def act(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
        key: PRNGKeyArray,
    ) -> Float[Array, "action"]:
        """The evaluation policy: an action in [-1, 1] for a state and a goal state.

        `key` is for this action only.
        """
