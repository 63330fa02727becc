"""QRL: quasimetric reinforcement learning, which learns the largest distance a constraint allows.

Wang et al. (2023), "Optimal Goal-Reaching Reinforcement Learning via Quasimetric Learning". QRL,
Eik-QRL and HJB-QRL differ only in the constraint. The shape of the push, the margin, the dual
variable, the latent dynamics and the actor's BC weight (that of the cubes) are OGBench's.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Literal

import jax
import jax.numpy as jnp
from jaxtyping import Float, PRNGKeyArray, Scalar

from pigbench.agents import actors, losses
from pigbench.agents.actors import PolicyAgent
from pigbench.agents.agent import Params
from pigbench.agents.batch import Batch
from pigbench.agents.config import PolicyConfig, ValueConfig
from pigbench.agents.constraints import Constraint, TransitionConstraint
from pigbench.agents.goals import QRL_VALUE_GOALS, GoalMixture
from pigbench.agents.metrics import LossAndMetrics, combine, describe
from pigbench.agents.networks import LatentDynamics, apply
from pigbench.agents.quasimetrics import QUASIMETRICS, Quasimetric
from pigbench.agents.residuals import Transitions
from pigbench.errors import UserError, lookup, require
from pigbench.shapes import Array
from pigbench.support.schema import BY_KIND


@dataclass(frozen=True)
class DDPGBCExtraction:
    """DDPG+BC: the policy maximises -d through a model of the dynamics, and clones actions.

    The model is in the embedding space of d, and trained beside it.
    """

    bc_weight: float = 0.3  # alpha of DDPG+BC
    kind: Literal["ddpg+bc"] = "ddpg+bc"  # ddpg+bc or awr

    def __post_init__(self) -> None:
        require(self, lambda x: x >= 0, "at least 0", "bc_weight")

    def init(self, agent: "QRL", key: PRNGKeyArray) -> Params:
        """Parameters of "dynamics"."""
        latents, actions = jnp.zeros(agent.config.latent_size), jnp.zeros(agent.action_size)
        return {"dynamics": agent.dynamics.init(key, latents=latents, actions=actions)}

    def loss(
        self,
        agent: "QRL",
        params: Params,
        latents: Float[Array, "batch n"],
        next_latents: Float[Array, "batch n"],
        batch: Batch,
    ) -> LossAndMetrics:
        """The losses of dynamics and policy; `latents` and `next_latents` embed s and s'."""
        frozen, frozen_latents = jax.lax.stop_gradient((params, latents))
        goals = agent.encode(frozen, batch.actor_goals)

        def critic(actions: Float[Array, "batch action"]) -> Float[Array, "batch"]:
            return -agent.distance(frozen, agent.predict(frozen, frozen_latents, actions), goals)

        return combine(
            self._dynamics_loss(agent, params, latents, next_latents, batch.actions),
            actors.ddpg_bc(
                agent.means(params, batch.observations, batch.actor_goals),
                batch.actions,
                critic,
                bc_weight=self.bc_weight,
            ),
        )

    def _dynamics_loss(
        self,
        agent: "QRL",
        params: Params,
        latents: Float[Array, "batch n"],
        next_latents: Float[Array, "batch n"],
        actions: Float[Array, "batch action"],
    ) -> LossAndMetrics:
        """The distance between next embedding and prediction, averaged over both directions."""
        predicted = agent.predict(params, latents, actions)
        starts = jnp.stack([next_latents, predicted])
        ends = jnp.stack([predicted, next_latents])
        loss = agent.distance(params, starts, ends).mean()
        return loss, {"dynamics/loss": loss}


@dataclass(frozen=True)
class AWRExtraction:
    """Advantage-weighted regression, where an advantage is by how much a step shortens d."""

    temperature: float = 10.0  # alpha of AWR
    kind: Literal["awr"] = "awr"  # ddpg+bc or awr

    def __post_init__(self) -> None:
        require(self, lambda x: x >= 0, "at least 0", "temperature")

    def init(self, agent: "QRL", key: PRNGKeyArray) -> Params:
        """No parameters: it needs no model."""
        return {}

    def loss(
        self,
        agent: "QRL",
        params: Params,
        latents: Float[Array, "batch n"],
        next_latents: Float[Array, "batch n"],
        batch: Batch,
    ) -> LossAndMetrics:
        """The policy's loss; `latents` and `next_latents` embed s and s'."""
        frozen, latents, next_latents = jax.lax.stop_gradient((params, latents, next_latents))
        goals = agent.encode(frozen, batch.actor_goals)
        distances, next_distances = agent.distance(
            frozen, jnp.stack([latents, next_latents]), goals
        )
        return actors.awr(
            agent.means(params, batch.observations, batch.actor_goals),
            batch.actions,
            distances - next_distances,
            temperature=self.temperature,
        )


Extraction = Annotated[DDPGBCExtraction | AWRExtraction, BY_KIND]


@dataclass(frozen=True)
class QRLConfig(PolicyConfig, ValueConfig):
    """Hyperparameters of QRL."""

    quasimetric: str = "iqe"  # iqe or mrn
    latent_size: int = 512  # size of the embeddings between which distances are measured
    constraint: Constraint = field(default_factory=TransitionConstraint)  # on distances
    push_offset: float = 500.0  # the distance beyond which the push fades
    push_beta: float = 0.01  # how sharply it fades
    actor: Extraction = field(default_factory=DDPGBCExtraction)  # how the policy is extracted
    value_goals: GoalMixture = QRL_VALUE_GOALS

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.goals != "state":
            raise UserError(
                f"goals is {self.goals!r}: a quasimetric measures distances between states, "
                "so it must be 'state'"
            )
        lookup("quasimetric", QUASIMETRICS, self.quasimetric)
        require(self, lambda x: x > 0, "positive", "push_offset", "push_beta")
        size = QUASIMETRICS[self.quasimetric].divisor
        require(
            self, lambda x: x > 0 and x % size == 0, f"a positive multiple of {size}", "latent_size"
        )


class QRL(PolicyAgent[QRLConfig]):
    """V(s, g) = -d(s, g) with a quasimetric d, a dual variable, and a Gaussian policy."""

    @property
    def penalty(self) -> Constraint:
        """The constraint."""
        return self.config.constraint

    @cached_property
    def quasimetric(self) -> Quasimetric:
        """The network of d."""
        config = self.config
        kind = QUASIMETRICS[config.quasimetric]
        return kind(config.value_hidden_sizes, config.latent_size, config.layer_norm)

    @cached_property
    def dynamics(self) -> LatentDynamics:
        """The network that predicts the next state's embedding."""
        return LatentDynamics(self.config.value_hidden_sizes, layer_norm=self.config.layer_norm)

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "value", "policy" and, for DDPG+BC, "dynamics"; log of the "multiplier"."""
        value_key, dynamics_key, policy_key = jax.random.split(key, 3)
        return {
            "value": self.quasimetric.init(value_key, **self.inputs),
            "multiplier": jnp.zeros(()),
            "policy": self.init_policy(policy_key),
            **self.config.actor.init(self, dynamics_key),
        }

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """Value, dynamics and actor losses. `key` is unused."""
        states = jnp.stack([batch.observations, batch.next_observations, batch.value_goals])
        latents, next_latents, goal_latents = self.encode(params, states)
        return combine(
            self._value_loss(params, latents, next_latents, goal_latents, batch),
            self.config.actor.loss(self, params, latents, next_latents, batch),
        )

    def state_value(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
    ) -> Scalar:
        """-d(s, g)."""
        latents, goal_latents = self.encode(params, jnp.stack([observation, goal]))
        return -self.distance(params, latents, goal_latents)

    def _value_loss(
        self,
        params: Params,
        latents: Float[Array, "batch n"],
        next_latents: Float[Array, "batch n"],
        goal_latents: Float[Array, "batch n"],
        batch: Batch,
    ) -> LossAndMetrics:
        config = self.config
        distances = self.distance(params, latents, goal_latents)
        step_distances = self.distance(params, latents, next_latents)

        def value(states: Float[Array, "batch observation"]) -> Float[Array, "batch"]:
            return -self.distance(params, self.encode(params, states), goal_latents)

        transitions = Transitions(batch.observations, batch.next_observations, self.coordinates)
        violation = config.constraint.violations(value, transitions, step_distances).mean()
        push = losses.push_apart(distances, offset=config.push_offset, beta=config.push_beta).mean()
        loss = push + losses.lagrangian(
            params["multiplier"], violation, margin=config.constraint.margin
        )
        return loss, describe("value", -distances) | {
            "value/push": push,
            "value/step_distance": step_distances.mean(),
            "dual/violation": violation,
            "dual/multiplier": jnp.exp(params["multiplier"]),
        }

    def encode(
        self, params: Params, states: Float[Array, "*batch observation"]
    ) -> Float[Array, "*batch n"]:
        """The embeddings of states, between which `distance` measures."""
        return apply(self.quasimetric, params["value"], method="encode", observations=states)

    def distance(
        self, params: Params, starts: Float[Array, "*batch n"], ends: Float[Array, "*#batch n"]
    ) -> Float[Array, "*batch"]:
        """d from one embedding to another."""
        return apply(self.quasimetric, params["value"], method="distance", starts=starts, ends=ends)

    def predict(
        self,
        params: Params,
        latents: Float[Array, "batch n"],
        actions: Float[Array, "batch action"],
    ) -> Float[Array, "batch n"]:
        """The embeddings of the states that actions lead to."""
        return apply(self.dynamics, params["dynamics"], latents=latents, actions=actions)
