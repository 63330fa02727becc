"""Defaults of data sets and their rows, without importing JAX."""

from typing import Literal

EPISODE_ROWS = 1001
"""Rows of an episode, as in OGBench: one more than its transitions."""

HomeChoice = Literal["auto", "device", "disk"]
"""Where rows are during training; "auto" is the device if they leave it enough memory to work."""
