"""Episodes of OGBench's generator in OGBench's physics, with all that is needed to replay them."""

import itertools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from pigbench import envs
from pigbench.fidelity import peer
from pigbench.fidelity.peer import Info, Step

_REPORT_EVERY = 100  # control steps


class PeerRecording(NamedTuple):
    """One episode of control steps, with the states before each step and the last one.

    `contact` is the gripper's contact number and `opening` its opening, both in [0, 1].
    """

    qpos: Float[np.ndarray, "time+1 nq"]
    qvel: Float[np.ndarray, "time+1 nv"]
    warmstart: Float[np.ndarray, "time nv"]
    pinch_pos: Float[np.ndarray, "time+1 3"]  # metres
    pinch_yaw: Float[np.ndarray, "time+1"]  # radians
    opening: Float[np.ndarray, "time+1"]
    contact: Float[np.ndarray, "time+1"]
    observations: Float[np.ndarray, "time observation"]
    actions: Float[np.ndarray, "time action"]
    ended: Bool[np.ndarray, "time"]  # the sub-task ended with this step
    success: Bool[np.ndarray, "time"]  # its cube is then at its target
    cube: Int[np.ndarray, "time"]  # the sub-task's cube
    target: Float[np.ndarray, "time 3"]  # metres, that cube's target


def record(
    environment: str,
    policy: str,
    *,
    episodes: int,
    steps: int,
    seed: int,
    report: Callable[[int], object] = lambda _: None,
) -> list[PeerRecording]:
    """Record episodes of `steps` control steps; `report` is called with how many more are done."""
    env = peer.make(environment, mode="data_collection")
    stacking = envs.SPECS[environment].stacking
    recordings = []
    for number in range(seed, seed + episodes):
        with peer.numpy_seed(number):
            taken: list[Step] = []
            episode = peer.episode(env, policy, seed=number, stacking=stacking)
            for step in itertools.islice(episode, steps):
                taken.append(step)
                if len(taken) % _REPORT_EVERY == 0:
                    report(_REPORT_EVERY)
        report(steps % _REPORT_EVERY)
        recordings.append(_as_arrays(taken))
    return recordings


def _as_arrays(steps: Sequence[Step]) -> PeerRecording:
    before = [step.before for step in steps]
    states = [*before, steps[-1].after]

    def column(infos: Sequence[Info], name: str) -> Shaped[np.ndarray, "row *value"]:
        return np.array([np.squeeze(info[name]) for info in infos])

    return PeerRecording(
        qpos=column(states, "qpos"),
        qvel=column(states, "qvel"),
        warmstart=column(before, "warmstart"),
        pinch_pos=column(states, "proprio/effector_pos"),
        pinch_yaw=column(states, "proprio/effector_yaw"),
        opening=column(states, "proprio/gripper_opening"),
        contact=column(states, "proprio/gripper_contact"),
        observations=column(before, "observation"),
        actions=np.array([step.action for step in steps]),
        ended=np.array([step.ended for step in steps]),
        success=column([step.after for step in steps], "success").astype(bool),
        cube=column(before, "privileged/target_block"),
        target=column(before, "privileged/target_block_pos"),
    )
