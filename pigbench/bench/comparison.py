"""Simulation here and in OGBench, side by side."""

from collections.abc import Mapping, Sequence

from pigbench import envs
from pigbench.bench import peers, simulation
from pigbench.bench.timing import Contender, Timing
from pigbench.fidelity import peer


def generation(
    environment: str, simulations: int, *, engine: str, profiles: Sequence[str]
) -> list[Contender]:
    """Data generation in OGBench and, in each physics profile, here and by the engine alone."""
    contenders = [peers.generation(environment)]
    for profile in profiles:
        env = envs.make(environment, engine=engine, profile=profile)
        contenders += [
            simulation.generation(env, simulations, name=_ours(profile)),
            simulation.engine(env, simulations, name=_alone(profile)),
        ]
    return contenders


def evaluation(
    environment: str,
    episodes: int,
    *,
    method: str,
    preset: str,
    engine: str,
    profiles: Sequence[str],
) -> list[Contender]:
    """Evaluation of an untrained policy in OGBench and, in each physics profile, here."""
    environments = {
        profile: envs.make(environment, engine=engine, profile=profile) for profile in profiles
    }
    ours = [
        simulation.evaluation(env, episodes, method, preset, name=_ours(profile))
        for profile, env in environments.items()
    ]
    return [peers.evaluation(envs.make(environment), method, preset), *ours]


def table(timings: Mapping[str, Timing]) -> list[tuple[str, ...]]:
    """Control steps per second, compared with OGBench's, with a header."""
    lines = [
        (
            name,
            f"{1 / timing.median:,.0f}",
            f"{timings[peer.NAME].ratio(timing):.1f}",
            f"{timing.first:.1f}",
        )
        for name, timing in timings.items()
    ]
    return [("", "control steps per second", f"times {peer.NAME}", "s of the first call"), *lines]


def share_of_engine(timings: Mapping[str, Timing], profile: str) -> float:
    """The rate of data generation in a physics profile, divided by that of the engine alone."""
    return timings[_alone(profile)].ratio(timings[_ours(profile)])


def _ours(profile: str) -> str:
    return f"pigbench {profile}"


def _alone(profile: str) -> str:
    return f"{_ours(profile)}, engine alone"
