"""The paper's results on its robot, from "Real-world Experiments", for comparison with ours."""

from collections.abc import Mapping

ROBOT: Mapping[tuple[str, str], Mapping[float, float]] = {
    ("gcivl", "cube-centre"): {0.03: 25, 0.05: 40, 0.10: 45},
    ("hjb-gcivl", "cube-centre"): {0.03: 40, 0.05: 50, 0.10: 65},
    ("h-flow-gcivl", "cube-centre"): {0.03: 25, 0.05: 40, 0.10: 40},
    ("pi-h-flow-hjb-gcivl", "cube-centre"): {0.03: 50, 0.05: 60, 0.10: 75},
}
"""Success in percent over 20 episodes, by method and environment, then by metres from the goal."""
