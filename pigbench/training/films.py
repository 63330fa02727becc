"""Films of simulations, and of a policy's evaluation episodes, the first of each task."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pigbench.agents import Agent, Params
from pigbench.envs import CubeEnv
from pigbench.envs.rendering import Renderer
from pigbench.envs.scene import CONTROL_STEP
from pigbench.support import pictures
from pigbench.training.evaluate import Evaluation, Report
from pigbench.training.recording import make_recorder

_SIZE = {"width": 320, "height": 240}

Filmer = Callable[[Params, Path, Report], None]


class Shot(NamedTuple):
    """Simulation states (rows, nq), and the goal (num_cubes, 3) to be shown, if any."""

    qpos: np.ndarray
    goal: np.ndarray | None


def write(
    path: Path,
    renderer: Renderer,
    shots: Iterable[Shot],
    drawn: Callable[[], object] = lambda: None,
) -> None:
    """Writes the film of shots at the simulation's own pace; `drawn` is called at each picture."""

    def frames() -> Iterator[np.ndarray]:
        for shot in shots:
            for qpos in shot.qpos:
                yield renderer.draw(qpos, shot.goal)
                drawn()

    pictures.write_mp4(path, frames(), rate=round(1 / CONTROL_STEP))


def make_filmer(env: CubeEnv, agent: Agent, evaluation: Evaluation) -> Filmer:
    """A function that writes the film of a policy, given its parameters, to a file."""
    record = make_recorder(env, agent, Evaluation(1, evaluation.seed))

    def film(params: Params, path: Path, report: Report) -> None:
        shots = [Shot(recording.qpos, recording.target) for recording in record(params, report)]
        with Renderer(env.spec.num_cubes, **_SIZE) as renderer:
            write(path, renderer, shots)

    return film
