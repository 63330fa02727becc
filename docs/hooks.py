"""Adds what is outside `docs` to the site: results, examples, and the package for the API page."""

import re
import shutil
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.plugins import event_priority
from mkdocs.structure.files import File, Files

_ROOT = Path(__file__).parents[1]
_SHOWN = {
    "results": {".md", ".png", ".csv", ".json", ".jsonl", ".py"},
    "examples": {".py", ".png", ".md", ".txt"},
}
_PACKAGE = _ROOT / "build" / "api" / "pigbench"


@event_priority(100)  # before the plugin looks for the package
def on_config(config: MkDocsConfig) -> None:
    """Copy the package as it is laid out when installed, with `agents` and `envs` inside it."""
    shutil.rmtree(_PACKAGE, ignore_errors=True)
    for source, part in {"pigbench": ".", "agents": "agents", "envs": "envs"}.items():
        shutil.copytree(_ROOT / source, _PACKAGE / part, dirs_exist_ok=True)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add pages, pictures and logs of `results`, and examples with their output."""
    for folder, suffixes in _SHOWN.items():
        for path in sorted((_ROOT / folder).rglob("*")):
            if path.suffix in suffixes:
                name = path.relative_to(_ROOT).as_posix()
                files.append(File.generated(config, name, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page, **_: object) -> str:
    """Point links to folders at their pages, and links into and out of `docs` into the site."""
    source = _ROOT / page.file.src_uri
    if not source.exists():  # a page of `docs`
        source = _ROOT / "docs" / page.file.src_uri

    def link(match: re.Match[str]) -> str:
        target, anchor = match["target"], match["anchor"] or ""
        if ":" in target or not target:
            return match[0]
        if (source.parent / target / "README.md").exists():
            target = f"{target.rstrip('/')}/README.md"
        if source.is_relative_to(_ROOT / "docs"):
            target = target.removeprefix("../")
        else:
            target = target.replace("../docs/", "../")
        return f"]({target}{anchor})"

    return re.sub(r"\]\((?P<target>[^)#\s]*)(?P<anchor>#[^)\s]*)?\)", link, markdown)
