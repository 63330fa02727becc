"""What a data set and its rows are unless asked otherwise: known without JAX."""

from typing import Literal

EPISODE_ROWS = 1001
"""Rows of an episode, OGBench's number: one transition fewer."""

HomeChoice = Literal["auto", "device", "disk"]
"""Where rows live while methods train; "auto" is the device where they leave it room to work."""
