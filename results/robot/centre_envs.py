"""`cube-centre` without some of its difficulties: `pigbench ... --plugin centre_envs.py`."""

from dataclasses import replace

from pigbench import envs
from pigbench.envs.reality import REAL, Reality

CENTRE = envs.SPECS["cube-centre"]
NONE, ESTIMATE = Reality(), REAL.estimate
LOST_FRAMES = {
    name: getattr(ESTIMATE, name)
    for name in ("latency", "dropout", "occlusion_distance", "occluded_dropout")
}
REALITIES = {
    "centre-easy": None,
    "centre-pose": REAL,
    # Errors of the estimated pose alone.
    "centre-noise": replace(
        NONE, estimate=replace(ESTIMATE, latency=0, dropout=0, occluded_dropout=0)
    ),
    # What is late or lost, but exact otherwise.
    "centre-late": replace(
        NONE, action_delay=REAL.action_delay, estimate=replace(NONE.estimate, **LOST_FRAMES)
    ),
}

envs.register(replace(CENTRE, name="centre-ideal", reality=None))
for name, reality in REALITIES.items():
    envs.register(replace(CENTRE, name=name, reality=reality, unobserved=frozenset()))
