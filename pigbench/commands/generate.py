"""`pigbench generate`: collect an offline data set with a scripted policy."""

import contextlib
import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from pigbench import devices, envs, settings
from pigbench.cluster import Cluster
from pigbench.data.defaults import EPISODE_ROWS
from pigbench.data.manifest import Spec
from pigbench.data.writer import Writer
from pigbench.envs.scripted import SCRIPTED
from pigbench.errors import UserError, lookup, require, require_left_out
from pigbench.provenance import package_versions
from pigbench.seeds import Seed
from pigbench.support import files, memory, typed
from pigbench.support.lock import only_writer

if TYPE_CHECKING:
    from pigbench.data import collect
    from pigbench.envs.oracles import ScriptedPolicy

_SHARD_OF_HOST, _SHARD_OF_ACCELERATOR = 50, 2048
"""Default numbers of episodes simulated at once: an accelerator needs thousands."""


@dataclasses.dataclass(frozen=True)
class Generate:
    """Collect an offline data set with a scripted policy.

    If the command was interrupted, run it again: finished shards are kept, and the result has the
    bytes of an uninterrupted run.
    """

    environment: tyro.conf.Positional[str]
    """Environment; see `pigbench list envs`."""
    out: Path
    """Folder of the data set."""
    policy: str | None = None
    """Scripted policy: play follows noisy plans, noisy reacts to the scene with noisy actions,
    replan plans anew for the only cube at every step, like a robot that has only estimates. By
    default the environment's own, which is play for all but cube-centre."""
    episodes: int = 1000
    """Episodes in the training split."""
    validation_episodes: int | None = None
    """Episodes in the validation split; by default a tenth of the training split."""
    seed: Seed = 0
    """Seed of all random numbers."""
    episode_length: int | None = None
    """Rows per episode, by default 1,001 as in OGBench; replan ends its episodes itself, after at
    most 301 rows."""
    compact: bool = False
    """Leave out qpos and qvel, which no method trains on, to halve the size."""
    episodes_per_shard: int | None = None
    """Episodes simulated at once and written as one shard; by default a number suited to the
    engine."""
    engine: str | None = None
    """Physics engine, by default the one for this device."""
    physics: Annotated[str, tyro.conf.arg(help_behavior_hint="(default: exact)")] = "exact"
    """Physics profile: exact has OGBench's contact geometry, fast simpler fingers."""

    cluster: Annotated[Cluster, tyro.conf.arg(name="")] = dataclasses.field(default_factory=Cluster)
    """Where shards are simulated."""

    def __post_init__(self) -> None:  # so that a suite rejects bad values before it begins
        counts = "episodes", "episode_length", "episodes_per_shard"
        require(self, lambda x: x is None or x >= 1, "at least 1", *counts)
        if self.split_episodes["val"] < 0:
            raise UserError(
                f"validation_episodes is {self.validation_episodes}: it must be 0 or more"
            )
        ability, spec = SCRIPTED[self._policy()], envs.get(self.environment)
        ability.require(self._policy(), spec.name, spec.num_cubes)
        if ability.episode_rows:
            where = f"with policy {self._policy()!r}, which ends its episodes itself"
            require_left_out(self, where, "episode_length")
        if self.episodes_per_shard is not None:
            memory.require_for(self.episodes_per_shard)

    def run(self) -> None:
        """Generate the missing shards."""
        from pigbench.data import collect
        from pigbench.envs.oracles import POLICIES

        files.require_folder(self.out)
        engine = self.engine or envs.default_engine()
        env = envs.make(self.environment, engine=engine, profile=self.physics)
        policy = POLICIES[self._policy()](env.spec, env.scene)
        spec = Spec(
            environment=self.environment,
            policy=self._policy(),
            physics=self.physics,
            engine=engine,
            seed=self.seed,
            episodes=self.split_episodes,
            episodes_per_shard=self._episodes_per_shard(engine),
            rows_per_episode=self.rows_per_episode,
            fields=collect.COMPACT if self.compact else collect.FIELDS,
            layout=env.layout,
            action_size=env.action_size,
            versions=package_versions(),
            settings=settings.in_force(),
        )
        if not self.out.exists():  # otherwise only the missing shards count
            most = collect.most_rows(policy, spec.rows_per_episode)
            every = sum(spec.episodes.values()) * most
            collect.require_room(env, spec.fields, every, self.out)
        with only_writer(self.out):
            writer = Writer(self.out, spec)
            if writer.missing():
                with self._source(env, policy, spec) as source:
                    collect.write_missing(env, policy, spec, writer, source)
        print(typed.complete(self.out, seen_by="data info"))

    @property
    def split_episodes(self) -> dict[str, int]:
        """The episodes of each split."""
        validation = self.validation_episodes
        return {
            "train": self.episodes,
            "val": max(1, self.episodes // 10) if validation is None else validation,
        }

    @property
    def rows_per_episode(self) -> int:
        """The rows of every episode; 0 if the policy ends episodes itself."""
        if SCRIPTED[self._policy()].episode_rows:
            return 0
        return self.episode_length or EPISODE_ROWS

    @contextlib.contextmanager
    def _source(
        self, env: "envs.CubeEnv", policy: "ScriptedPolicy", spec: Spec
    ) -> Iterator["collect.Source"]:
        from pigbench.data import collect, remote

        if self.cluster.ray is None:
            yield collect.local_source(env, policy, spec)
        else:
            with self.cluster.connected() as tasks:
                yield remote.source(spec, tasks)

    def _policy(self) -> str:
        """The name of the scripted policy. Raises UserError if there is none of that name."""
        usual = envs.get(self.environment).policy
        name = usual if self.policy is None else self.policy
        lookup("policy", SCRIPTED, name)
        return name

    def _episodes_per_shard(self, engine: str) -> int:
        from pigbench.envs.physics.mujoco import MujocoPhysics

        if self.episodes_per_shard is not None:
            return self.episodes_per_shard
        if engine == MujocoPhysics.name or devices.backend() == "cpu":
            return _SHARD_OF_HOST
        return min(_SHARD_OF_ACCELERATOR, self.episodes)
