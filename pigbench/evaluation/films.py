"""Films of simulations, and of an evaluation: a success and a failure of each task."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from pigbench import envs
from pigbench.envs.rendering import Renderer
from pigbench.envs.units import CONTROL_STEP
from pigbench.evaluation.recording import Recording
from pigbench.support import files, pictures

_WIDTH, _HEIGHT = 320, 240  # pixels
_EVERY = 2  # control steps between two frames of an evaluation's film


class Shot(NamedTuple):
    """Simulation states, and the goal to show, if any."""

    qpos: Float[np.ndarray, "time nq"]
    goal: Float[np.ndarray, "cube 3"] | None


def write(
    path: Path,
    renderer: Renderer,
    shots: Iterable[Shot],
    drawn: Callable[[], object] = lambda: None,
    *,
    every: int = 1,
) -> None:
    """Write a film of every `every`-th state, at the simulation's own pace.

    `drawn` is called after each frame.
    """

    def frames() -> Iterator[pictures.Picture]:
        for shot in shots:
            for qpos in shot.qpos[::every]:
                yield renderer.draw(qpos, shot.goal)
                drawn()

    pictures.write_mp4(path, frames(), rate=round(1 / (CONTROL_STEP * every)))


def film(env: "envs.CubeEnv", recordings: Iterable[Recording], folder: Path) -> dict[str, Path]:
    """Film recorded episodes of an evaluation into a folder.

    Returns the files by names such as "task1_horizontal/success".
    """
    paths = {}
    # Without shadows, a frame takes a third of the time.
    scene = Renderer(env.spec.num_cubes, width=_WIDTH, height=_HEIGHT, shadows=False)
    with scene as renderer:
        for name, recording in _examples(env, recordings).items():
            paths[name] = folder / f"{name.replace('/', '-')}.mp4"
            shot = Shot(recording.qpos, recording.target)
            write(paths[name], renderer, [shot], every=_EVERY)
    return paths


def keep_films(folder: Path, wanted: Callable[[int], bool]) -> None:
    """Remove the films of unwanted steps from a run's folder of films; other files stay."""
    for path in folder.glob("*"):
        if path.name.isdecimal() and not wanted(int(path.name)):
            files.remove_folder(path)


def _examples(env: "envs.CubeEnv", recordings: Iterable[Recording]) -> dict[str, Recording]:
    """The first success and the first failure of each task."""
    examples: dict[str, Recording] = {}
    for recording in recordings:
        task = env.spec.tasks[recording.task - 1].name
        outcome = "success" if recording.success else "failure"
        examples.setdefault(f"{task}/{outcome}", recording)
    return examples
