"""`pigbench train`: train one method with one seed."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Generic, TypeVar

import jax
import tyro

from pigbench import agents, dataset, envs
from pigbench.agents import AgentConfig
from pigbench.dataset import Dataset
from pigbench.evaluate import Evaluation
from pigbench.provenance import provenance
from pigbench.runs import RunConfig, open_run
from pigbench.sampler import Rows
from pigbench.train import Schedule, train

Config = TypeVar("Config", bound=AgentConfig)


@dataclasses.dataclass(frozen=True)
class _Choice:
    """What decides which other fields there are."""

    method: tyro.conf.Positional[str] = "gcivl"
    preset: str = "paper"


@dataclasses.dataclass(frozen=True)
class Train(Generic[Config]):
    """Train one method with one seed, evaluating it as it learns.

    Run the same command again after it was cut off: it goes on from the last checkpoint and ends
    with the same parameters.
    """

    method: tyro.conf.Positional[str]
    """Method; see `pigbench list methods`."""
    data: Path
    """Folder of the data set."""
    out: Path
    """Folder of the run."""
    agent: Config
    """The method's hyper-parameters, by default those of the preset."""
    preset: str = "paper"
    """Preset of hyper-parameters: paper, or cpu for networks that two cores can train."""
    seed: int = 0
    """Seed of initial parameters, batches and updates."""
    steps: int = Schedule.steps
    """Number of updates."""
    log_every: int = Schedule.log_every
    """Updates between two lines of metrics."""
    evaluate_every: int = Schedule.evaluate_every
    """Updates between two evaluations; each is followed by a checkpoint."""
    evaluation: Evaluation = Evaluation()
    """How the policy is evaluated."""
    engine: str = envs.DEFAULT_ENGINE
    """Physics engine of the evaluation."""

    @classmethod
    def specialize(cls, arguments: Sequence[str]) -> tuple[Any, "Train"]:
        """This class for the chosen method, and its defaults for the chosen preset."""
        choice, _ = tyro.cli(_Choice, args=arguments, add_help=False, return_unknown_args=True)
        method = agents.get(choice.method)
        config = method.preset(choice.preset)
        default = cls(tyro.MISSING, tyro.MISSING, tyro.MISSING, config, choice.preset)
        return cls[type(config)], default

    def run(self) -> None:
        """Train to the end, or go on where an earlier run was cut off."""
        schedule = Schedule(self.steps, self.log_every, self.evaluate_every)
        data = dataset.load(self.data)
        env = envs.make(data.spec.environment, engine=self.engine, profile=data.spec.physics)
        dataset.check_layout(data, env.layout)
        agent = agents.build(
            self.method,
            self.agent,
            observation_size=env.observation_size,
            action_size=env.action_size,
            layout=env.layout,
        )
        run = open_run(
            self.out,
            RunConfig(
                method=self.method,
                preset=self.preset,
                agent=dataclasses.asdict(self.agent),
                environment=data.spec.environment,
                physics=data.spec.physics,
                dataset_digest=data.digest,
                steps=self.steps,
                seed=self.seed,
                evaluation=dataclasses.asdict(self.evaluation)
                | {"every": self.evaluate_every, "engine": self.engine},
            ),
            provenance(dataset=self.data, dataset_digest=data.digest),
        )
        state = train(
            run,
            agent,
            _rows(data),
            env,
            schedule=schedule,
            evaluation=self.evaluation,
            seed=self.seed,
        )
        jax.block_until_ready(state)
        print(f"{self.out} is complete; see it with: pigbench table {self.out}")


def _rows(data: Dataset) -> Rows:
    split = data.split("train")
    return Rows.create(
        *(split.concatenate(field) for field in ("observations", "actions", "terminals"))
    )
