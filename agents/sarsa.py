"""Values of the behaviour policy, learned as probabilities by a double critic and a value.

As in SHARSA (Park et al., 2025, "Horizon Reduction Makes RL Scalable") and in "High-level critic
and value losses" of the paper's appendix.
"""

from dataclasses import dataclass
from functools import cached_property

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Float, PRNGKeyArray

from pigbench.agents.agent import Params
from pigbench.agents.metrics import LossAndMetrics, describe
from pigbench.agents.networks import Critic, Value, apply, apply_ensemble, init_ensemble
from pigbench.shapes import Array


@dataclass(frozen=True)
class Sarsa:
    """Q_1, Q_2(s, a, g) and V(s, g): the expected discount^(steps to the goal).

    The networks output its logit. An action is any choice made at s, such as a subgoal. The agent's
    parameters hold them as "critic" (members stacked), which has a target copy, and "value".
    """

    hidden_sizes: tuple[int, ...]
    layer_norm: bool
    members = 2

    @cached_property
    def critic(self) -> Critic:
        """The network of one Q."""
        return Critic(self.hidden_sizes, layer_norm=self.layer_norm)

    @cached_property
    def value(self) -> Value:
        """The network of V."""
        return Value(self.hidden_sizes, layer_norm=self.layer_norm)

    def init(
        self,
        key: PRNGKeyArray,
        *,
        observations: Float[Array, "*batch observation"],
        actions: Float[Array, "*batch action"],
        goals: Float[Array, "*batch goal"],
    ) -> Params:
        """Initial parameters, for inputs of these sizes."""
        critic_key, value_key = jax.random.split(key)
        return {
            "critic": init_ensemble(
                self.critic,
                critic_key,
                self.members,
                observations=observations,
                actions=actions,
                goals=goals,
            ),
            "value": self.value.init(value_key, observations=observations, goals=goals),
        }

    def loss(
        self,
        params: Params,
        target_params: Params,
        *,
        observations: Float[Array, "batch observation"],
        actions: Float[Array, "batch action"],
        goals: Float[Array, "batch goal"],
        next_observations: Float[Array, "batch observation"],
        success: Float[Array, "batch"],
        discounts: Float[Array, "batch"],
    ) -> LossAndMetrics:
        """Binary cross-entropies of Q_1 and Q_2 with their backup, and of V with min(Q_1, Q_2).

        `discounts` are discount^k for transitions of k steps. `success` is 1 where a
        transition ends at the goal, else 0; the reward there is discount^k, and the goal terminal.
        """
        inputs = {"observations": observations, "actions": actions, "goals": goals}
        next_logits = apply(
            self.value, params["value"], observations=next_observations, goals=goals
        )
        next_values = jax.lax.stop_gradient(jax.nn.sigmoid(next_logits))
        backups = discounts * jnp.where(success, 1, next_values)
        critic_logits = apply_ensemble(self.critic, params["critic"], **inputs)
        critic_loss = optax.sigmoid_binary_cross_entropy(critic_logits, backups).sum(axis=0).mean()

        values = self.score(target_params, **inputs)
        value_logits = apply(self.value, params["value"], observations=observations, goals=goals)
        value_loss = optax.sigmoid_binary_cross_entropy(value_logits, values).mean()

        return critic_loss + value_loss, {
            "critic/loss": critic_loss,
            "value/loss": value_loss,
            **describe("critic", jax.nn.sigmoid(critic_logits)),
            **describe("value", jax.nn.sigmoid(value_logits)),
        }

    def best(
        self,
        params: Params,
        *,
        observation: Float[Array, "observation"],
        goal: Float[Array, "goal"],
        candidates: Float[Array, "candidate action"],
    ) -> Float[Array, "action"]:
        """The candidate of the highest score."""
        scores = self.score(params, observations=observation, actions=candidates, goals=goal)
        return candidates[jnp.argmax(scores)]

    def score(
        self,
        params: Params,
        *,
        observations: Float[Array, "*#batch observation"],
        actions: Float[Array, "*batch action"],
        goals: Float[Array, "*#batch goal"],
    ) -> Float[Array, "*batch"]:
        """min(Q_1, Q_2) in (0, 1)."""
        observations, goals = (
            jnp.broadcast_to(inputs, (*actions.shape[:-1], inputs.shape[-1]))
            for inputs in (observations, goals)
        )
        logits = apply_ensemble(
            self.critic, params["critic"], observations=observations, actions=actions, goals=goals
        )
        return jax.nn.sigmoid(logits).min(axis=0)
