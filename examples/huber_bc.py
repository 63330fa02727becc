"""Goal-conditioned behaviour cloning with the Huber loss."""

from dataclasses import dataclass

import optax

from pigbench import agents
from pigbench.agents.actors import PolicyAgent


@dataclass(frozen=True)
class HuberBCConfig(agents.PolicyConfig):
    """Hyperparameters: those of all policies, and the error above which the loss is linear."""

    delta: float = 0.1


class HuberBC(PolicyAgent[HuberBCConfig]):
    """A deterministic policy; `PolicyAgent` has its network and acts with it."""

    def init(self, key):
        """Parameters of the policy's network."""
        return {"policy": self.init_policy(key)}

    def loss(self, params, target_params, batch, key):
        """The loss that Adam minimises, and metrics."""
        actions = self.means(params, batch.observations, batch.actor_goals)
        errors = optax.huber_loss(actions, batch.actions, delta=self.config.delta)
        loss = errors.sum(axis=-1).mean()
        return loss, {"actor/loss": loss}


agents.register(
    agents.Method(
        name="huber-bc",
        agent=HuberBC,
        config=HuberBCConfig(),
        summary="behaviour cloning with the Huber loss",
    )
)
