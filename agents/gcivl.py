"""GCIVL: goal-conditioned implicit value learning with an advantage-weighted actor.

The value loss may include a physics-informed regulariser, which is all that distinguishes GCIVL,
Eik-GCIVL and HJB-GCIVL. The losses are those of the paper's appendix, under "Low-level
HJB-regularized value loss" and "Low-level actor loss", with the full state instead of the low-level
one.
"""

from dataclasses import dataclass, field
from functools import cached_property

import jax
import jax.numpy as jnp
from jaxtyping import Float, PRNGKeyArray, PyTree, Scalar

from pigbench.agents import actors, losses
from pigbench.agents.actors import PolicyAgent
from pigbench.agents.agent import Params
from pigbench.agents.batch import Batch
from pigbench.agents.config import PolicyConfig, TargetConfig
from pigbench.agents.metrics import LossAndMetrics, combine, describe
from pigbench.agents.networks import Value, apply, apply_ensemble, init_ensemble
from pigbench.agents.regularizers import NoRegularizer, Regularizer
from pigbench.agents.residuals import Transitions, ValuesAndResiduals
from pigbench.errors import lookup, require
from pigbench.shapes import Array


@dataclass(frozen=True)
class GCIVLConfig(PolicyConfig, TargetConfig):
    """Hyperparameters of GCIVL; the defaults are the paper's where it names them."""

    expectile: float = 0.9  # iota, of the value loss
    temperature: float = 10.0  # alpha: actions have weight exp(alpha * advantage), at most 100
    rewards: str = "-1/0"  # rewards before and at the goal: -1/0 or 0/1
    regularizer: Regularizer = field(default_factory=NoRegularizer)  # the value loss's penalty

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: 0 < x < 1, "between 0 and 1, both excluded", "expectile")
        require(self, lambda x: x >= 0, "at least 0", "temperature")
        lookup("rewards", GOAL_REWARDS, self.rewards)


GOAL_REWARDS = {"-1/0": 0.0, "0/1": 1.0}
"""The reward r_g at the goal, by the name of the rewards; before the goal it is 1 less.

With V_c the value for rewards -1/0, V = r_g + c V_c, where c = 1 for -1/0 and 1 - discount for 0/1.
"""


class GCIVL(PolicyAgent[GCIVLConfig]):
    """Two values V_i(s, g) with target copies, and a Gaussian policy with standard deviation 1."""

    target_networks = ("value",)
    members = 2

    @property
    def penalty(self) -> Regularizer:
        """The regulariser."""
        return self.config.regularizer

    @cached_property
    def value(self) -> Value:
        """The network of one ensemble member."""
        return Value(self.config.value_hidden_sizes, layer_norm=self.config.layer_norm)

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "value" (two members, stacked) and "policy"."""
        value_key, policy_key = jax.random.split(key)
        return {
            "value": init_ensemble(self.value, value_key, self.members, **self.inputs),
            "policy": self.init_policy(policy_key),
        }

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """Value loss plus actor loss, which train disjoint networks. `key` is unused."""
        return combine(
            self._value_loss(params["value"], target_params["value"], batch),
            self.actor_loss(params, batch),
        )

    def state_value(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
    ) -> Scalar:
        """The mean of the members as V_c, the value for rewards -1/0, whatever the rewards."""
        goal = self.as_goals(goal)
        values = apply_ensemble(self.value, params["value"], observations=observation, goals=goal)
        return (values.mean(axis=0) - self._goal_reward) / self._cost_scale

    @property
    def _goal_reward(self) -> float:
        return GOAL_REWARDS[self.config.rewards]

    @property
    def _cost_scale(self) -> float:
        """c, by which values exceed those for a cost of 1 per step."""
        return 1 - self.config.discount if self._goal_reward else 1.0

    def _value_loss(self, members: PyTree, targets: PyTree, batch: Batch) -> LossAndMetrics:
        config = self.config
        goals = self.as_goals(batch.value_goals)
        transitions = Transitions(batch.observations, batch.next_observations, self.coordinates)

        def regularized(member: PyTree) -> ValuesAndResiduals:
            # Residuals assume a cost of 1 per step; they do not see r_g, which is constant.
            def as_costs(states: Float[Array, "batch observation"]) -> Float[Array, "batch"]:
                values = apply(self.value, member, observations=states, goals=goals)
                return values / self._cost_scale

            values, residuals = config.regularizer.residuals(as_costs, transitions)
            return values * self._cost_scale, residuals

        values, residuals = jax.vmap(regularized)(members)
        target_values, next_values = self._transition_values(targets, batch, batch.value_goals)
        td_loss = losses.implicit_value(
            values,
            target_values,
            next_values,
            batch.value_success,
            discount=config.discount,
            level=config.expectile,
            goal_reward=self._goal_reward,
        ).mean()
        regularization = config.regularizer.weight * residuals.sum(axis=0).mean()
        return td_loss + regularization, describe("value", values) | {
            "value/td_loss": td_loss,
            "value/regularization": regularization,
            "value/residual": residuals.mean(),
        }

    def actor_loss(self, params: Params, batch: Batch) -> LossAndMetrics:
        """Advantage-weighted regression. Override it to change only how the policy is trained."""
        advantages = self.advantages(params, batch)
        means = self.means(params, batch.observations, batch.actor_goals)
        return actors.awr(means, batch.actions, advantages, temperature=self.config.temperature)

    def advantages(self, params: Params, batch: Batch) -> Float[Array, "batch"]:
        """V(s', g) - V(s, g) for the actor's goals, averaged over members, no gradient."""
        values, next_values = self._transition_values(
            jax.lax.stop_gradient(params["value"]), batch, batch.actor_goals
        )
        return next_values.mean(axis=0) - values.mean(axis=0)

    def _transition_values(
        self, members: PyTree, batch: Batch, goals: Float[Array, "batch observation"]
    ) -> tuple[Float[Array, "member batch"], Float[Array, "member batch"]]:
        """V_i(s, g) and V_i(s', g), in one call."""
        states = jnp.stack([batch.observations, batch.next_observations])
        goals = jnp.stack([self.as_goals(goals)] * 2)
        values = apply_ensemble(self.value, members, observations=states, goals=goals)
        return values[:, 0], values[:, 1]
