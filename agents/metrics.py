"""Losses with their metrics: what training logs of each part of an agent."""

from collections.abc import Mapping
from typing import TypeVar

import jax.numpy as jnp
from jaxtyping import Float, Scalar

from pigbench.shapes import Array

Metrics = dict[str, Scalar]  # "<part>/<quantity>" -> value
LossAndMetrics = tuple[Scalar, Metrics]

T = TypeVar("T")


def combine(*parts: LossAndMetrics) -> LossAndMetrics:
    """The sum of the parts' losses, and all their metrics."""
    metrics = {name: value for _, part in parts for name, value in part.items()}
    return jnp.stack([loss for loss, _ in parts]).sum(), metrics


def describe(part: str, values: Float[Array, "..."]) -> Metrics:
    """The mean, minimum and maximum of `values`, as metrics of `part`."""
    return {
        f"{part}/mean": values.mean(),
        f"{part}/min": values.min(),
        f"{part}/max": values.max(),
    }


def add_prefix(prefix: str, entries: Mapping[str, T]) -> dict[str, T]:
    """`entries` with `prefix` added to every name, to tell the levels of a hierarchy apart."""
    return {prefix + name: entry for name, entry in entries.items()}


def take_prefix(prefix: str, entries: Mapping[str, T]) -> dict[str, T]:
    """The inverse of `add_prefix`: the entries with this prefix, without it."""
    return {
        name.removeprefix(prefix): entry
        for name, entry in entries.items()
        if name.startswith(prefix)
    }
