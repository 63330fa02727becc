"""Goal-conditioned behaviour cloning with Huber's loss."""

from dataclasses import dataclass

import optax

from pigbench import agents
from pigbench.agents.actors import PolicyAgent


@dataclass(frozen=True)
class HuberBCConfig(agents.AgentConfig):
    """Hyper-parameters: the shared ones, and where squares end."""

    delta: float = 0.1


class HuberBC(PolicyAgent[HuberBCConfig]):
    """A deterministic policy: `PolicyAgent` has its network, and acts by it."""

    def init(self, key):
        """Parameters of the policy's network."""
        return {"policy": self.init_policy(key)}

    def loss(self, params, target_params, batch, key):
        """What Adam minimises, and metrics."""
        actions = self.means(params, batch.observations, batch.actor_goals)
        errors = optax.huber_loss(actions, batch.actions, delta=self.config.delta)
        loss = errors.sum(axis=-1).mean()
        return loss, {"actor/loss": loss}


agents.register(
    agents.Method(
        name="huber-bc",
        agent=HuberBC,
        config=HuberBCConfig(),
        summary="behaviour cloning with Huber's loss",
    )
)
