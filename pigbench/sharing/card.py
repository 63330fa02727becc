"""The README of a shared folder, in the form that the Hugging Face hub expects.

A YAML header describes the folder's contents to the hub, Markdown to people.
"""

import json
from collections.abc import Mapping
from typing import Any

from pigbench import envs
from pigbench.envs import terms
from pigbench.envs.units import ACTION_SCALE, ACTION_SIZE, CONTROL_STEP
from pigbench.layout import Layout

FILE_NAME = "README.md"

LICENSE = "apache-2.0"
"""The hub's name for the default licence, which is that of pigbench."""

TAGS = ("pigbench", "robotics", "offline-rl", "goal-conditioned-rl")

ACTION = (
    f"An action is a relative move in [-1, 1]^{ACTION_SIZE}, for {CONTROL_STEP:g} s: x, y and z by "
    f"up to {100 * ACTION_SCALE[0]:g} cm, yaw by up to {ACTION_SCALE[3]:g} rad, the gripper by up "
    "to its whole opening."
)


def card(header: Mapping[str, Any], *sections: str) -> str:
    """The file's text; the header's values must be serialisable as JSON."""
    fields = "".join(f"{name}: {json.dumps(value)}\n" for name, value in header.items())
    return f"---\n{fields}---\n\n" + "\n\n".join(sections) + "\n"


def code(language: str, text: str) -> str:
    """A block of code."""
    return f"```{language}\n{text.strip()}\n```"


def facts(values: Mapping[str, Any]) -> str:
    """A list of names and values, without those that are empty."""
    return "\n".join(f"- {name}: {value}" for name, value in values.items() if value != "")


def observation_table(environment: str, layout: Layout) -> str:
    """The positions of an observation's terms, and their meanings as far as they are known."""
    meanings = _meanings(environment)
    rows = [
        f"| `{name}` | {part.start} to {part.stop - 1} | {meanings.get(name, '')} |"
        for name, part in layout.items()
    ]
    return "\n".join(["| term | numbers | meaning |", "|---|---|---|", *rows])


def _meanings(environment: str) -> Mapping[str, str]:
    spec = envs.SPECS.get(environment)
    return {term.name: term.meaning for term in terms.table(spec.num_cubes)} if spec else {}
