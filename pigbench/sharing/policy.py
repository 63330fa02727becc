"""A trained policy for others: a folder that can act wherever JAX runs, without pigbench.

parameters.safetensors  the parameters of every network, by path
act.jax_export          `act(parameters, observations, goals, key)`, serialised by `jax.export`
policy.json             what was trained and on which data, and the observation's layout
README.md               the same for people, with the lines that make it act
"""

import contextlib
import dataclasses
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Key, Shaped

from pigbench import seeds, xla
from pigbench.agents import Agent, Params
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.provenance import package_versions
from pigbench.runs.restore import Trained
from pigbench.settings import jax_defaults
from pigbench.sharing import card
from pigbench.support import files, lock
from pigbench.support.extras import required

States = Float[Array, "batch observation"]
Actions = Float[Array, "batch action"]

FORMAT = 1
PARAMETERS_FILE = "parameters.safetensors"
ACT_FILE = "act.jax_export"
CONFIG_FILE = "policy.json"

_PLATFORMS = ("cpu", "cuda", "tpu")
_PLACES = "jax_traceback_in_locations_limit"  # JAX's setting: source locations per operation

_USAGE = """
import importlib.metadata
import os

# On a CPU, these versions get some sums wrong without this flag (jax-ml/jax#39103).
if importlib.metadata.version("jaxlib") in {faulty}:
    os.environ["XLA_FLAGS"] = os.environ.get("XLA_FLAGS", "") + " {cure}"

import jax
from safetensors.numpy import load_file

parameters = load_file("{parameters}")
with open("{act}", "rb") as file:
    act = jax.jit(jax.export.deserialize(bytearray(file.read())).call)
# observations and goals: (batch, {size}) in float32; actions: (batch, {action_size})
key = jax.random.key(0, impl="{implementation}")
actions = act(parameters, observations, goals, key)
"""


def write(folder: Path, trained: Trained, *, license: str = card.LICENSE) -> None:
    """Write the policy of a run's checkpoint to `folder`, completely or not at all.

    Raises UserError if a package is missing, or if `folder` contains something other than a policy.
    """
    # `jax.export` writes flatbuffers.
    safetensors, _ = required("safetensors.numpy", "flatbuffers", extra="share")
    _require_own(folder)
    parameters = by_path(jax.device_get(trained.state.acting))
    about = describe(trained)
    with lock.replacing_folder(folder) as new:
        files.write_bytes(new / PARAMETERS_FILE, safetensors.save(parameters))
        files.write_bytes(new / ACT_FILE, serialize(trained.agent, trained.state.acting))
        files.write_json(new / CONFIG_FILE, about)
        files.write_text(new / card.FILE_NAME, _card(trained, about, license))


def by_path(tree: Any) -> dict[str, Any]:
    """The leaves of a tree by path, such as "policy/params/MLP_0/Dense_0/bias"."""
    leaves = jax.tree_util.tree_leaves_with_path(tree)
    return {jax.tree_util.keystr(path, simple=True, separator="/"): leaf for path, leaf in leaves}


@jax_defaults()
def serialize(agent: Agent, params: Params) -> bytes:
    """The agent's serialised policy, which takes parameters `by_path` and batches of any size."""
    names, structure = list(by_path(params)), jax.tree.structure(params)
    act_on_batch = batched(agent)

    def act(
        parameters: Mapping[str, Shaped[Array, "..."]],
        observations: States,
        goals: States,
        key: Key[Array, ""],
    ) -> Actions:
        tree = jax.tree.unflatten(structure, [parameters[name] for name in names])
        return act_on_batch(tree, observations, goals, key)

    (batch,) = jax.export.symbolic_shape("batch")
    states = jax.ShapeDtypeStruct((batch, agent.observation_size), jnp.float32)
    parameters, key = jax.eval_shape(lambda: (by_path(params), seeds.key(0)))
    with _without_places():
        exported = jax.export.export(jax.jit(act), platforms=_PLATFORMS)(
            parameters, states, states, key
        )
    return bytes(exported.serialize())


def batched(agent: Agent) -> Callable[[Params, States, States, Key[Array, ""]], Actions]:
    """The agent's policy on a batch, each of whose examples has draws of its own from one key."""

    def act(params: Params, observations: States, goals: States, key: Key[Array, ""]) -> Actions:
        keys = jax.vmap(jax.random.fold_in, (None, 0))(key, jnp.arange(observations.shape[0]))
        return jax.vmap(agent.act, (None, 0, 0, 0))(params, observations, goals, keys)

    return act


@contextlib.contextmanager
def _without_places() -> Iterator[None]:
    """Omit source locations from programs: they would name files on this machine."""
    before = getattr(jax.config, _PLACES)
    jax.config.update(_PLACES, 0)
    try:
        yield
    finally:
        jax.config.update(_PLACES, before)


def describe(trained: Trained) -> dict[str, Any]:
    """A description of the policy, ready for JSON."""
    run, agent = trained.run, trained.agent
    return {
        "format": FORMAT,
        "step": int(trained.state.step),
        "success": _success(trained),
        "observation": [
            {"name": name, "start": part.start, "stop": part.stop}
            for name, part in agent.layout.items()
        ],
        "action_size": agent.action_size,
        "config": dataclasses.asdict(run.config),
        "statistics": files.read_sealed(run.statistics_path),
        "provenance": files.read_json(run.provenance_path),
        "exported_with": package_versions(("pigbench", "jax")),
    }


def _success(trained: Trained) -> dict[str, Any] | None:
    """The success rate over this checkpoint's evaluation episodes; None if there are none."""
    step = int(trained.state.step)
    rows = [row for row in episodes.read_any(trained.run.episodes_path) if row.step == step]
    if not rows:
        return None
    return {
        "rate": float(np.mean([row.measures["success"] for row in rows])),
        "episodes": len(rows),
        "engine": rows[0].engine,
    }


def _require_own(folder: Path) -> None:
    if not folder.exists() or (folder / CONFIG_FILE).exists():
        return
    if not folder.is_dir() or files.entries(folder):
        raise UserError(f"{folder} is not an empty folder and holds no policy; choose another")


def _card(trained: Trained, about: Mapping[str, Any], license: str) -> str:
    config, agent = trained.run.config, trained.agent
    success = about["success"]
    usage = _USAGE.format(
        faulty=xla.FAULTY,
        cure=xla.CURE,
        parameters=PARAMETERS_FILE,
        act=ACT_FILE,
        size=agent.observation_size,
        action_size=agent.action_size,
        implementation=seeds.IMPLEMENTATION,
    )
    return card.card(
        {
            "license": license,
            "library_name": "jax",
            "pipeline_tag": "reinforcement-learning",
            "tags": [*card.TAGS, config.method, config.environment],
        },
        f"# {config.label} on {config.environment}",
        card.facts(
            {
                "method": config.label,
                "environment": f"{config.environment}, physics profile {config.physics}",
                "success": f"{success['rate']:.1%} of {success['episodes']} evaluation episodes "
                f"(engine {success['engine']})"
                if success
                else "not evaluated",
                "updates": f"{about['step']:,}, seed {config.seed}, preset {config.preset}",
                "data set": f"the one whose manifest has SHA-256 {config.dataset_digest}",
                "goals": "the states to reach"
                + ("" if config.goals == "state" else f", of which it sees the {config.goals}"),
            }
        ),
        f"## Acting\n\nWith jax, flatbuffers and safetensors installed, in this folder:\n\n"
        f"{card.code('python', usage)}",
        f"## Observations, goals and actions\n\n"
        f"{card.observation_table(config.environment, agent.layout)}\n\n"
        f"A goal is an observation too. {card.ACTION}",
        f"`{CONFIG_FILE}` has every hyperparameter, and versions.",
    )
