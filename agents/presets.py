"""Presets of hyperparameters by name, without JAX."""

from collections.abc import Mapping
from typing import Any

_NETWORKS = {
    "actor_hidden_sizes": (256, 256, 256),
    "value_hidden_sizes": (256, 256, 256),
    "latent_size": 128,
    "actor_layer_norm": True,
}

PRESETS: Mapping[str, Mapping[str, Any]] = {
    "paper": {},
    "cpu": {
        "batch_size": 256,
        "learning_rate": 1e-3,
        "discount": 0.99,
        "target_rate": 0.03,
        "candidates": 4,
        "average_rate": 1e-3,
        **_NETWORKS,
        "low": {**_NETWORKS, "rewards": "0/1"},
    },
}
"""The changes to a method's configuration, as far as it has the fields.

The values of `cpu`, but for the sizes of its networks, were found by a search, which
`results/search` documents.
"""
