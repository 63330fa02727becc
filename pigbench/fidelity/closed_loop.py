"""A policy in OGBench's simulator and in ours, from the same starts to the same goals."""

from functools import partial
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Bool

from pigbench import envs
from pigbench.agents import Agent, Params
from pigbench.evaluation import rollouts
from pigbench.evaluation.rollouts import Report, make_evaluator
from pigbench.evaluation.settings import Evaluation
from pigbench.fidelity import peer


class Successes(NamedTuple):
    """Which episodes succeeded; both of a pair have one start and goal."""

    ours: Bool[np.ndarray, "task episode"]
    theirs: Bool[np.ndarray, "task episode"]


class PairCounts(NamedTuple):
    """Counts of pairs by outcome, and the probability of so uneven a split by chance alone."""

    both: int
    only_ours: int
    only_theirs: int
    neither: int
    p: float


def simulate(
    env: "envs.CubeEnv", agent: Agent, params: Params, evaluation: Evaluation, report: Report
) -> Successes:
    """Run the evaluation's episodes in both simulators; the policy uses the same keys in both.

    `report` is called with the number of episodes done by OGBench's simulator, by far the slower.
    """
    ours = make_evaluator(env, agent, evaluation)(params, lambda _: None)["success"]
    rollout = jax.jit(partial(rollouts.begin, env, evaluation))()
    states = rollout.states
    qpos, target, goals = jax.device_get(
        (env.simulation(states).qpos, states.info["target"], states.info["goal"])
    )
    act = jax.jit(partial(rollouts.action, agent))
    simulator = peer.make(env.spec.name, mode="task")
    with peer.quiet():
        simulator.reset(seed=evaluation.seed, options={"task_id": 1})  # compiles its model

    def succeeds(number: int) -> bool:
        observation = peer.place(simulator, qpos[number], target[number])
        key, goal = rollout.act_keys[number], goals[number]
        for time in range(env.episode_length):
            action = act(params, np.float32(observation), goal, key, time)
            observation, _, _, _, info = simulator.step(np.asarray(action))
            if info["success"]:
                return True
        return False

    theirs = np.zeros(ours.size, bool)
    for number in range(ours.size):
        theirs[number] = succeeds(number)
        report(number + 1)
    return Successes(ours, theirs.reshape(ours.shape))


def compare(successes: Successes) -> PairCounts:
    """The counts and the p-value of McNemar's exact test."""
    from scipy import stats  # takes long

    ours, theirs = successes
    only_ours, only_theirs = int((ours & ~theirs).sum()), int((theirs & ~ours).sum())
    unlike = only_ours + only_theirs
    return PairCounts(
        both=int((ours & theirs).sum()),
        only_ours=only_ours,
        only_theirs=only_theirs,
        neither=int((~ours & ~theirs).sum()),
        p=float(stats.binomtest(only_ours, unlike).pvalue) if unlike else 1.0,
    )
