"""`cube-centre` without some of its difficulties: `pigbench ... --plugin centre_envs.py`.

The environments' own imperfections follow from the variable PART: noise, late, or neither.
"""

import os
from dataclasses import replace

from pigbench import envs
from pigbench.envs import reality
from pigbench.envs.reality import REAL, Reality

CENTRE = envs.SPECS["cube-centre"]
NONE, ESTIMATE = Reality(), REAL.estimate
LOST_FRAMES = {
    name: getattr(ESTIMATE, name)
    for name in ("latency", "dropout", "occlusion_distance", "occluded_dropout")
}
PARTS = {
    "": REAL,
    # Errors of the estimated pose alone.
    "noise": replace(NONE, estimate=replace(ESTIMATE, latency=0, dropout=0, occluded_dropout=0)),
    # What is late or lost, but exact otherwise.
    "late": replace(
        NONE, action_delay=REAL.action_delay, estimate=replace(NONE.estimate, **LOST_FRAMES)
    ),
}

reality.REAL = PARTS[os.environ.get("PART", "")]
envs.register(replace(CENTRE, name="centre-ideal", real=False))
envs.register(replace(CENTRE, name="centre-easy", real=False, unobserved=frozenset()))
for name in ("centre-pose", "centre-noise", "centre-late"):
    envs.register(replace(CENTRE, name=name, unobserved=frozenset()))
