"""QRL: quasimetric reinforcement learning, which learns the largest distance a constraint allows.

Wang et al. (2023), "Optimal Goal-Reaching Reinforcement Learning via Quasimetric Learning". QRL,
Eik-QRL and HJB-QRL differ only in the constraint. The shape of the push, the margin, the dual
variable, the latent dynamics and the actor's BC weight (that of the cubes) are OGBench's.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import jax
import jax.numpy as jnp

from pigbench.agents import actors, losses
from pigbench.agents.actors import PolicyAgent
from pigbench.agents.agent import Metrics, Params, combine, describe
from pigbench.agents.batch import Batch, GoalMixture
from pigbench.agents.config import AgentConfig
from pigbench.agents.constraints import Constraint
from pigbench.agents.networks import LatentDynamics
from pigbench.agents.quasimetrics import IQE, QUASIMETRICS, Quasimetric
from pigbench.errors import UserError, lookup, require

RANDOM_STATES = GoalMixture(current=0.0, future=0.0, random=1.0, geometric=False)


@dataclass(frozen=True)
class QRLConfig(AgentConfig):
    """Hyperparameters of QRL."""

    quasimetric: str = "iqe"  # iqe or mrn
    latent_size: int = 512  # size of the embeddings between which distances are measured
    constraint: Constraint = field(default_factory=Constraint)  # the constraint on distances
    push_offset: float = 500.0  # the distance beyond which the push fades
    push_beta: float = 0.01  # how sharply it fades
    actor: str = "ddpg+bc"  # ddpg+bc or awr
    bc_weight: float = 0.3  # alpha of DDPG+BC
    temperature: float = 10.0  # alpha of AWR
    value_goals: GoalMixture = RANDOM_STATES

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.goals != "state":
            raise UserError(
                f"goals is {self.goals!r}: a quasimetric measures distances between states, "
                "so it must be 'state'"
            )
        lookup("quasimetric", QUASIMETRICS, self.quasimetric)
        lookup("actor", ACTOR_LOSSES, self.actor)
        require(self, lambda x: x > 0, "positive", "push_offset", "push_beta")
        require(self, lambda x: x >= 0, "at least 0", "bc_weight", "temperature")
        size = IQE.component_size
        require(
            self, lambda x: x > 0 and x % size == 0, f"a positive multiple of {size}", "latent_size"
        )


class QRL(PolicyAgent[QRLConfig]):
    """V(s, g) = -d(s, g) with a quasimetric d, a dual variable, and a Gaussian policy.

    DDPG+BC maximises -d through a dynamics model in the embedding space of d; AWR needs no model.
    """

    @property
    def residual_constants(self) -> Constraint:
        """The constraint's."""
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

    def init(self, key: jax.Array) -> Params:
        """Parameters of "value", "policy" and, for DDPG+BC, "dynamics"; log of the "multiplier"."""
        value_key, dynamics_key, policy_key = jax.random.split(key, 3)
        states = jnp.zeros((1, self.observation_size))
        params = {
            "value": self.quasimetric.init(value_key, observations=states, goals=states),
            "multiplier": jnp.zeros(()),
            "policy": self.init_policy(policy_key),
        }
        if self.config.actor == "ddpg+bc":
            params["dynamics"] = self.dynamics.init(
                dynamics_key,
                latents=jnp.zeros((1, self.config.latent_size)),
                actions=jnp.zeros((1, self.action_size)),
            )
        return params

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: jax.Array
    ) -> tuple[jax.Array, Metrics]:
        """Value, dynamics and actor losses. `key` is unused."""
        states = jnp.stack([batch.observations, batch.next_observations, batch.value_goals])
        here, there, goals = self._encode(params, states)
        return combine(
            self._value_loss(params, here, there, goals, batch),
            ACTOR_LOSSES[self.config.actor](self, params, here, there, batch),
        )

    def state_values(self, params: Params, observations: jax.Array, goals: jax.Array) -> jax.Array:
        """-d(s, g)."""
        here, there = self._encode(params, jnp.stack([observations, goals]))
        return -self._distance(params, here, there)

    def _value_loss(
        self, params: Params, here: jax.Array, there: jax.Array, goals: jax.Array, batch: Batch
    ) -> tuple[jax.Array, Metrics]:
        config = self.config
        distances = self._distance(params, here, goals)
        step_distances = self._distance(params, here, there)

        def value(states: jax.Array) -> jax.Array:
            return -self._distance(params, self._encode(params, states), goals)

        violation = config.constraint(
            value,
            batch.observations,
            batch.next_observations,
            step_distances,
            self.direction(config.constraint.direction),
        ).mean()
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

    def _awr_loss(
        self, params: Params, here: jax.Array, there: jax.Array, batch: Batch
    ) -> tuple[jax.Array, Metrics]:
        frozen, here, there = jax.lax.stop_gradient((params, here, there))
        goals = self._encode(frozen, batch.actor_goals)
        distances, next_distances = self._distance(frozen, jnp.stack([here, there]), goals)
        return actors.awr(
            self.means(params, batch.observations, batch.actor_goals),
            batch.actions,
            distances - next_distances,
            temperature=self.config.temperature,
        )

    def _ddpg_bc_loss(
        self, params: Params, here: jax.Array, there: jax.Array, batch: Batch
    ) -> tuple[jax.Array, Metrics]:
        frozen, frozen_here = jax.lax.stop_gradient((params, here))
        goals = self._encode(frozen, batch.actor_goals)

        def critic(actions: jax.Array) -> jax.Array:
            return -self._distance(frozen, self._predict(frozen, frozen_here, actions), goals)

        return combine(
            self._dynamics_loss(params, here, there, batch.actions),
            actors.ddpg_bc(
                self.means(params, batch.observations, batch.actor_goals),
                batch.actions,
                critic,
                bc_weight=self.config.bc_weight,
            ),
        )

    def _dynamics_loss(
        self, params: Params, here: jax.Array, there: jax.Array, actions: jax.Array
    ) -> tuple[jax.Array, Metrics]:
        """The distance between next embedding and prediction, averaged over both directions."""
        predicted = self._predict(params, here, actions)
        there, predicted = jnp.stack([there, predicted]), jnp.stack([predicted, there])
        loss = self._distance(params, there, predicted).mean()
        return loss, {"dynamics/loss": loss}

    def _encode(self, params: Params, states: jax.Array) -> Any:
        return self.quasimetric.apply(params["value"], observations=states, method="encode")

    def _distance(self, params: Params, starts: jax.Array, ends: jax.Array) -> Any:
        return self.quasimetric.apply(params["value"], starts=starts, ends=ends, method="distance")

    def _predict(self, params: Params, latents: jax.Array, actions: jax.Array) -> Any:
        return self.dynamics.apply(params["dynamics"], latents=latents, actions=actions)


ACTOR_LOSSES = {"ddpg+bc": QRL._ddpg_bc_loss, "awr": QRL._awr_loss}
"""The losses that train the policy, by name."""
