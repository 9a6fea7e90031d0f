"""Where the site is made, and which page of it each file of the repository becomes."""

from __future__ import annotations

import tomllib
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "build" / "docs"
"""The pages as they are handed to the site generator."""
SITE = ROOT / "build" / "site"
"""The site itself."""
_PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
REPOSITORY = str(_PROJECT.get("urls", {}).get("Repository", ""))
"""The address of the repository; empty until its owner has set it."""

_RENAMED = {
    "docs/gallery.md": "gallery.md",  # made by a script
    "docs/site/home.md": "index.md",
    "docs/README.md": "contents.md",
    "docs/decisions/README.md": "decisions/index.md",
    "README.md": "readme.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "changes/README.md": "changes.md",
    "experiments/README.md": "experiments.md",
}
_UNSEARCHED = (
    "CHANGELOG.md",
    "changes",
    "docs/decisions",
    "docs/reference/benchmarks.md",
    "docs/reference/errata.md",
    "docs/reference/mutation-tests.md",
    "docs/reference/nestml-neurons.md",
    "docs/reference/parity.md",
    "docs/reference/pynn-scripts.md",
    "docs/reference/robots.md",
    "docs/reference/simulator-examples.md",
    "docs/reference/speed.md",
    "docs/reference/spynnaker-public-scripts.md",
)
"""Tables of results, decisions and changes, which would hide the pages that a reader needs."""


def is_searched(file: PurePosixPath) -> bool:
    """Return whether the search of the site finds a document."""
    return not any(file.is_relative_to(place) for place in _UNSEARCHED)


def page_of(file: PurePosixPath) -> PurePosixPath | None:
    """Return the page that a file of the repository becomes, or None if it is shown as source."""
    name = str(file)
    if name in _RENAMED:
        return PurePosixPath(_RENAMED[name])
    if file.match("plugins/*/README.md"):
        return PurePosixPath("plugins", f"{file.parent.name}.md")
    if file.parts[:2] == ("docs", "notebooks"):
        return PurePosixPath("notebooks", f"{file.stem}.md")
    if file.parts[0] == "docs" and (file.suffix == ".md" or file.parts[1] == "images"):
        return file.relative_to("docs")
    return None


def source_page_of(file: PurePosixPath) -> PurePosixPath:
    """Return the page that shows a source file or a folder."""
    return PurePosixPath("source", f"{file}.md")


def documents() -> list[PurePosixPath]:
    """Return the Markdown files of the repository that are pages of the site."""
    found = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *ROOT.glob("*/README.md")]
    found += (ROOT / "plugins").glob("*/README.md")
    names = {PurePosixPath(path.relative_to(ROOT).as_posix()) for path in found}
    return sorted(name for name in names if page_of(name))
