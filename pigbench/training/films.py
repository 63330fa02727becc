"""Films of a policy's evaluation episodes, the first of each task."""

from collections.abc import Callable, Iterator
from pathlib import Path

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


def make_filmer(env: CubeEnv, agent: Agent, evaluation: Evaluation) -> Filmer:
    """A function that writes the film of a policy, given its parameters, to a file."""
    record = make_recorder(env, agent, Evaluation(1, evaluation.seed))

    def film(params: Params, path: Path, report: Report) -> None:
        recordings = record(params, report)
        with Renderer(env.spec.num_cubes, **_SIZE) as renderer:

            def frames() -> Iterator[np.ndarray]:
                for recording in recordings:
                    for qpos in recording.qpos:
                        yield renderer.draw(qpos, recording.target)

            pictures.write_mp4(path, frames(), rate=round(1 / CONTROL_STEP))

    return film
