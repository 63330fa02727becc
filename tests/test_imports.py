"""Which part of the code may import which, wherever in a file it does, and how it makes keys."""

import ast
import graphlib
import importlib.util
import itertools
from pathlib import Path

import pytest

PACKAGES = ("pigbench", "pigbench.agents", "pigbench.envs")


def code() -> dict[str, Path]:
    """Every module's file, by name; a package has its folder's name."""
    found = {}
    for package in PACKAGES:
        spec = importlib.util.find_spec(package)
        (folder,) = spec.submodule_search_locations
        for path in Path(folder).rglob("*.py"):
            parts = path.relative_to(folder).with_suffix("").parts
            found[".".join((package, *parts)).removesuffix(".__init__")] = path
    return found


CODE = code()


def imported(path: Path) -> set[str]:
    """The full names of all that a file imports."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path} has a relative import"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def within(name: str, *modules: str) -> bool:
    return any(f"{name}.".startswith(f"{module}.") for module in modules)


ABOVE = {
    "pigbench.cli": ("pigbench.__main__",),
    "pigbench.commands": ("pigbench.cli", "pigbench.commands"),
}
"""What everything else is below -> what may import it."""


def test_all_code_is_found():
    assert {"pigbench.suite.jobs", "pigbench.agents.losses", "pigbench.envs.physics"} <= set(CODE)
    assert "pigbench.commands.parsing.parse" in imported(CODE["pigbench.commands.suite"])


@pytest.mark.parametrize("above", ABOVE)
def test_nothing_imports_upwards(above):
    below = [name for name in CODE if not within(name, *ABOVE[above])]
    assert not [name for name in below if any(within(one, above) for one in imported(CODE[name]))]


def test_no_files_import_each_other_in_a_circle():
    """Not even by way of others, or for types alone."""

    def file(name: str) -> str:
        return name if name in CODE else name.rpartition(".")[0]  # the latter defines the former

    needs = {name: {*map(file, imported(path))} & {*CODE} for name, path in CODE.items()}
    graphlib.TopologicalSorter(needs).prepare()  # an error names the circle


@pytest.mark.parametrize(("one", "other"), [*itertools.permutations(PACKAGES[1:])])
def test_agents_and_environments_do_without_each_other(one, other):
    own = [name for name in CODE if within(name, one)]
    assert not [name for name in own if any(within(what, other) for what in imported(CODE[name]))]


KEYS = ("jax.random.key", "jax.random.PRNGKey", "jax.random.wrap_key_data")


def test_no_random_key_is_of_jaxs_default_implementation():
    """For that may be another on each machine."""
    made = [
        f"{name}, line {node.lineno}: {ast.unparse(node)}"
        for name, path in CODE.items()
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call)
        and ast.unparse(node.func) in KEYS
        and "impl" not in {keyword.arg for keyword in node.keywords}
    ]
    assert not made
