"""Settings of a fit that the paper leaves open."""

from dataclasses import dataclass

from pigbench.errors import require


@dataclass(frozen=True)
class Settings:
    """Settings that the paper leaves open. Raises UserError if a value is out of range."""

    half_width: float = 1.0
    """Positions are uniform in [-half_width, half_width]."""
    steps: int = 5000
    """Updates per fit."""
    batch_size: int = 256
    """Fresh states per mode in each update."""
    learning_rate: float = 1e-3
    """Adam's initial learning rate, which decays to 0 along a cosine."""
    hidden_sizes: tuple[int, ...] = (64, 64)
    """Hidden layers of the network."""

    def __post_init__(self) -> None:
        require(self, lambda x: x > 0, "positive", "half_width", "learning_rate")
        require(self, lambda x: x >= 1, "at least 1", "steps", "batch_size")
        require(self, lambda sizes: all(x > 0 for x in sizes), "positive numbers", "hidden_sizes")
