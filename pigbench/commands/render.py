"""`pigbench render` and `pigbench data render`: pictures and films, without a screen if need be."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from pigbench import envs, opengl, seeds
from pigbench.data import dataset
from pigbench.errors import require, require_left_out, unknown_own
from pigbench.evaluation.settings import Evaluation
from pigbench.seeds import Seed
from pigbench.support import pictures
from pigbench.support.progress import Progress

if TYPE_CHECKING:
    from pigbench.envs.rendering import Renderer
    from pigbench.evaluation.films import Shot

_LARGEST = 8192  # pixels; many OpenGL drivers draw no more


@dataclasses.dataclass(frozen=True)
class Size:
    """Size of pictures in pixels."""

    width: int = 640
    height: int = 480

    def __post_init__(self) -> None:
        even = f"an even number from 2 to {_LARGEST}"
        require(self, lambda x: 2 <= x <= _LARGEST and x % 2 == 0, even, *vars(self))


@dataclasses.dataclass(frozen=True)
class Render:
    """Draw a task's scene as a picture, or the evaluation episodes of a run as a film.

    Translucent cubes show the goal.
    """

    source: tyro.conf.Positional[str]
    """Environment (for a picture) or a run's folder (for a film)."""
    out: Path
    """File of the picture (.png) or the film (.mp4)."""
    task: int | None = None
    """Task, counted from 1; by default the first for a picture, and all for a film."""
    episodes: int | None = None
    """Episodes per task in a film, by default 1."""
    checkpoint: str | None = None
    """Policy of a run: last (the default), best, or that of a training step."""
    seed: Seed = Evaluation.seed
    """Seed of the scene, or of the evaluation."""
    engine: str | None = None
    """Physics engine, by default that of the run's own evaluations, or what suits this machine."""
    size: Size = dataclasses.field(default_factory=Size)
    """Size of the picture."""

    def run(self) -> None:
        """Draw and write the file."""
        if self.source in envs.SPECS:
            self._scene()
        elif Path(self.source).is_dir():
            self._run()
        else:
            raise unknown_own("environment or run", self.source, envs.names())
        print(f"{self.out} is drawn")

    def _scene(self) -> None:
        import jax
        import numpy as np

        from pigbench.envs.rendering import Renderer

        require_left_out(self, "on an environment's picture", "episodes", "checkpoint")
        pictures.check_path(self.out, ".png")
        opengl.choose()
        env = envs.make(self.source, engine=self.engine)
        task = 1 if self.task is None else self.task
        env.check_task(task)
        state = jax.jit(env.reset_task)(seeds.key(self.seed), task)
        qpos, goal = np.asarray(env.simulation(state).qpos), np.asarray(state.info["target"])
        with Renderer(env.spec.num_cubes, **dataclasses.asdict(self.size)) as renderer:
            picture = renderer.draw(qpos, goal)
        pictures.write_png(self.out, picture)

    def _run(self) -> None:
        from pigbench.envs.rendering import Renderer
        from pigbench.evaluation.films import Shot
        from pigbench.evaluation.recording import make_recorder
        from pigbench.runs.restore import restore

        pictures.check_path(self.out, ".mp4")
        opengl.choose()
        episodes = 1 if self.episodes is None else self.episodes
        evaluation = Evaluation(episodes, self.seed)
        _, env, agent, state = restore(
            Path(self.source), engine=self.engine, checkpoint=self.checkpoint or "last"
        )
        tasks = range(1, env.num_tasks + 1) if self.task is None else [self.task]
        for task in tasks:
            env.check_task(task)
        with Renderer(env.spec.num_cubes, **dataclasses.asdict(self.size)) as renderer:
            with Progress("evaluate", total=env.episode_length, unit="control steps") as progress:
                record = make_recorder(env, agent, evaluation)
                _, recordings = record(state.acting, progress.reach)
            shown = [recording for recording in recordings if recording.task in tasks]
            shots = [Shot(recording.qpos, recording.target) for recording in shown]
            _film(self.out, renderer, shots)
        for recording in shown:
            outcome = "success" if recording.success else "failure"
            name = env.spec.tasks[recording.task - 1].name
            print(f"{name:28} {outcome} after {len(recording.qpos) - 1} steps")


@dataclasses.dataclass(frozen=True)
class RenderData:
    """Draw an episode of a data set as a film."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""
    out: Path
    """File of the film (.mp4)."""
    episode: int = 0
    """Episode of the split, counted from 0."""
    split: str = "train"
    """Split: train or val."""
    size: Size = dataclasses.field(default_factory=Size)
    """Size of the picture."""

    def run(self) -> None:
        """Draw and write the file."""
        from pigbench.envs.rendering import Renderer
        from pigbench.evaluation.films import Shot

        pictures.check_path(self.out, ".mp4")
        opengl.choose()
        data = dataset.load(self.folder)
        shot = Shot(data.episode(self.split, self.episode, "qpos"), goal=None)
        spec = envs.get(data.spec.environment)
        with Renderer(spec.num_cubes, **dataclasses.asdict(self.size)) as renderer:
            _film(self.out, renderer, [shot])
        print(f"{self.out} is drawn")


def _film(path: Path, renderer: "Renderer", shots: Sequence["Shot"]) -> None:
    """Write the film, showing progress."""
    from pigbench.evaluation import films

    total = sum(len(shot.qpos) for shot in shots)
    with Progress("render", total=total, unit="pictures") as progress:
        films.write(path, renderer, shots, drawn=lambda: progress.advance(1))
