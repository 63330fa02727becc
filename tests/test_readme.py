"""The tests mirror the code but for what their README lists."""

import re
from pathlib import Path

TESTS = Path(__file__).parent
ROOT = TESTS.parent
CODE = ("agents", "envs", "pigbench")


def listed() -> list[dict[str, str]]:
    """Each table of the README: from every name in its first column to the second column."""
    tables: list[dict[str, str]] = []
    for line in (TESTS / "README.md").read_text().splitlines():
        if line == "| --- | --- |":
            tables.append({})
        elif tables and line.startswith("| `"):
            first, second = line.strip("| ").split(" | ")
            tables[-1] |= dict.fromkeys(re.findall(r"`(.+?)`", first), second.strip("`"))
    return tables


def files(top: Path, pattern: str) -> set[str]:
    """Files below `top`, but `__init__` and its like, without their ending."""
    found = (path.relative_to(top) for path in top.rglob(pattern))
    return {str(path.with_suffix("")) for path in found if not path.name.startswith("__")}


def test_every_module_has_its_tests_where_one_looks():
    through_others, of_no_module = listed()
    tests = files(TESTS, "test_*.py")
    modules = {f"{code}/{name}" for code in CODE for name in files(ROOT / code, "*.py")}
    folders = {str(path.relative_to(ROOT)) for code in CODE for path in (ROOT / code).rglob("*")}
    mirrored = {str(Path(name).with_name(f"test_{Path(name).name}")): name for name in modules}
    of_folders = {f"{folder}/test_{Path(folder).name}" for folder in folders | set(CODE)}
    assert modules - {mirrored[name] for name in tests & set(mirrored)} == set(through_others)
    assert tests - set(mirrored) - of_folders == set(of_no_module)
    assert set(through_others.values()) <= tests
