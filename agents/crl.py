"""CRL: contrastive reinforcement learning with a DDPG+BC actor.

The critic is trained to tell the goal reached after (s, a) from the goals of the other pairs in the
batch (Eysenbach et al., 2022, "Contrastive Learning as Goal-Conditioned Reinforcement Learning").
The actor's BC weight is OGBench's for the cube environments.
"""

from dataclasses import dataclass
from functools import cached_property

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Float, PRNGKeyArray, PyTree

from pigbench.agents import actors
from pigbench.agents.actors import PolicyAgent
from pigbench.agents.agent import Params
from pigbench.agents.batch import Batch
from pigbench.agents.config import PolicyConfig, ValueConfig
from pigbench.agents.goals import CRL_VALUE_GOALS, GoalMixture
from pigbench.agents.metrics import LossAndMetrics, combine
from pigbench.agents.networks import BilinearCritic, apply_ensemble, init_ensemble
from pigbench.errors import require
from pigbench.shapes import Array


@dataclass(frozen=True)
class CRLConfig(PolicyConfig, ValueConfig):
    """Hyperparameters of CRL."""

    bc_weight: float = 3.0  # alpha of DDPG+BC
    latent_size: int = 512  # size of both embeddings
    value_goals: GoalMixture = CRL_VALUE_GOALS

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: x >= 0, "at least 0", "bc_weight")
        require(self, lambda x: x > 0, "positive", "latent_size")


class CRL(PolicyAgent[CRLConfig]):
    """Two critics f_i(s, a, g) = phi_i(s, a) . psi_i(g) / sqrt(n), and a Gaussian policy."""

    members = 2

    @cached_property
    def critic(self) -> BilinearCritic:
        """The network of one critic."""
        config = self.config
        return BilinearCritic(config.value_hidden_sizes, config.latent_size, config.layer_norm)

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "critic" (two members, stacked) and "policy"."""
        critic_key, policy_key = jax.random.split(key)
        return {
            "critic": init_ensemble(self.critic, critic_key, self.members, **self.critic_inputs),
            "policy": self.init_policy(policy_key),
        }

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """Critic loss plus actor loss, which train disjoint networks. `key` is unused."""
        return combine(self._critic_loss(params, batch), self._actor_loss(params, batch))

    def _critic_loss(self, params: Params, batch: Batch) -> LossAndMetrics:
        """Binary cross-entropy that tells each row's own goal from those of all other rows."""
        phi, psi = self._embed(params["critic"], batch.actions, batch, batch.value_goals)
        logits = jnp.einsum("eik,ejk->eij", phi, psi)
        own = jnp.eye(logits.shape[-1])
        loss = optax.sigmoid_binary_cross_entropy(logits, own).mean()
        own_mean = jnp.trace(logits, axis1=1, axis2=2).mean() / len(own)
        return loss, {
            "critic/loss": loss,
            "critic/own_goal": own_mean,
            "critic/mean": logits.mean(),
            "critic/accuracy": jnp.mean(logits.mean(axis=0).argmax(axis=1) == jnp.arange(len(own))),
        }

    def _actor_loss(self, params: Params, batch: Batch) -> LossAndMetrics:
        members = jax.lax.stop_gradient(params["critic"])

        def critic(actions: Float[Array, "batch action"]) -> Float[Array, "batch"]:
            phi, psi = self._embed(members, actions, batch, batch.actor_goals)
            return jnp.sum(phi * psi, axis=-1).min(axis=0)

        means = self.means(params, batch.observations, batch.actor_goals)
        return actors.ddpg_bc(means, batch.actions, critic, bc_weight=self.config.bc_weight)

    def _embed(
        self,
        members: PyTree,
        actions: Float[Array, "batch action"],
        batch: Batch,
        goals: Float[Array, "batch observation"],
    ) -> tuple[Float[Array, "member batch n"], Float[Array, "member batch n"]]:
        """phi_i(s, a) and psi_i(g)."""
        goals = self.as_goals(goals)
        return apply_ensemble(
            self.critic, members, observations=batch.observations, actions=actions, goals=goals
        )
