"""Trackers that display training runs: TensorBoard, W&B, Trackio, or a class of one's own."""

from pigbench.trackers.registry import get, names, register
from pigbench.trackers.tracker import Tracker, evaluated

__all__ = ["Tracker", "evaluated", "get", "names", "register"]
