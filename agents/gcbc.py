"""GCBC: goal-conditioned behaviour cloning, which imitates the actions that led to the goal."""

from jaxtyping import PRNGKeyArray

from pigbench.agents import actors
from pigbench.agents.actors import PolicyAgent
from pigbench.agents.agent import Params
from pigbench.agents.batch import Batch
from pigbench.agents.config import PolicyConfig
from pigbench.agents.metrics import LossAndMetrics


class GCBC(PolicyAgent[PolicyConfig]):
    """A Gaussian policy with standard deviation 1."""

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "policy"."""
        return {"policy": self.init_policy(key)}

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """-log pi(a | s, g). `key` is unused."""
        means = self.means(params, batch.observations, batch.actor_goals)
        return actors.clone(means, batch.actions)
