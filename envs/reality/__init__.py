"""The imperfections of a real robot: estimated poses, delays and varying dynamics.

These are their settings, available without importing JAX; `sensing` applies them. `REAL` is the
setting of `cube-centre`; in `Reality()`, everything is zero, so nothing is imperfect.
"""

from dataclasses import dataclass, field

import numpy as np

from pigbench.errors import require

_DELAY = "a whole number of control steps, at least 0"


def _is_delay(steps: int) -> bool:
    return isinstance(steps, int | np.integer) and steps >= 0


@dataclass(frozen=True)
class PoseEstimate:
    """The error of an estimated pose; if all fields are 0, the estimate is exact.

    Raises UserError if a field is out of range.

    Attributes:
        position_noise: metres, standard deviation of each coordinate in every frame.
        yaw_noise: radians, likewise.
        position_bias: metres, standard deviation of each coordinate's error that lasts an episode.
        yaw_bias: radians, likewise.
        misregistration: the probability that an episode's track of a cube starts at a wrong pose.
        misregistration_bias: metres, replaces `position_bias` in that case.
        dropout: the probability that a frame is lost.
        occlusion_distance: metres from the pinch point within which the gripper covers a cube.
        occluded_dropout: the probability that a frame of a covered cube is lost.
        latency: control steps from a frame to its estimate.
    """

    position_noise: float = 0.0
    yaw_noise: float = 0.0
    position_bias: float = 0.0
    yaw_bias: float = 0.0
    misregistration: float = 0.0
    misregistration_bias: float = 0.0
    dropout: float = 0.0
    occlusion_distance: float = 0.0
    occluded_dropout: float = 0.0
    latency: int = 0

    def __post_init__(self) -> None:
        probabilities = "misregistration", "dropout", "occluded_dropout"
        errors = "position_noise", "yaw_noise", "position_bias", "yaw_bias", "misregistration_bias"
        require(self, lambda x: x >= 0, "at least 0", *errors, "occlusion_distance")
        require(self, lambda x: 0 <= x <= 1, "a probability, from 0 to 1", *probabilities)
        require(self, _is_delay, _DELAY, "latency")


@dataclass(frozen=True)
class Variation:
    """How far an episode's dynamics may deviate from the model's; 0 means not at all.

    Raises UserError if a field is out of range.

    Attributes:
        friction: the largest relative change of the friction of all contacts.
        mass: the largest relative change of the cubes' masses and inertias.
    """

    friction: float = 0.0
    mass: float = 0.0

    def __post_init__(self) -> None:
        require(self, lambda x: 0 <= x < 1, "at least 0 and below 1", "friction", "mass")


@dataclass(frozen=True)
class Reality:
    """The imperfections, each of which may be set to zero.

    Raises UserError if a field is out of range.

    Attributes:
        estimate: how the cubes' poses are estimated.
        action_delay: control steps until an action is executed.
        variation: the range of an episode's dynamics.
    """

    estimate: PoseEstimate = field(default_factory=PoseEstimate)
    action_delay: int = 0
    variation: Variation = field(default_factory=Variation)

    def __post_init__(self) -> None:
        require(self, _is_delay, _DELAY, "action_delay")


REAL = Reality(
    estimate=PoseEstimate(
        # FoundationPose (Wen et al., CVPR 2024, table 1): areas under the curve up to 10 cm of
        # 97.4 % (ADD-S) and 91.5 % (ADD) on YCB-Video are mean errors of 2.6 and 8.5 mm, and the
        # latter counts rotations under which an object is symmetric. The depth of a D415 (baseline
        # 55 mm, 65 degrees over 1280 pixels) is off by 1.4 mm at a metre if the disparity is off by
        # 0.08 pixels (Intel's notes on tuning its D400 cameras expect less than 0.1); a pose
        # averages over it.
        position_noise=0.002,
        yaw_noise=np.radians(2.0),
        # The calibration of a camera beside an arm is commonly accurate to a few millimetres.
        position_bias=0.003,
        yaw_bias=np.radians(1.0),
        # The tail of the errors is an assumption of this model, not a published figure (published
        # ADD recalls are means over frames that are good or far off).
        misregistration=0.1,
        misregistration_bias=0.03,
        dropout=0.02,
        # Half the fingers' length: they hide what is between them, not a whole cube.
        occlusion_distance=0.05,
        occluded_dropout=0.3,
        # 30 frames per second, and FoundationPose tracks at 32: two control steps, rounded up.
        latency=2,
    ),
    action_delay=1,  # a servo command's time in the controller, rounded up to a control step
    variation=Variation(friction=0.3, mass=0.3),
)
