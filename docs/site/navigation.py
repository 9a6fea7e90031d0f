"""The navigation of the site: the contents page (``docs/README.md``), and pages that only the site has."""

from __future__ import annotations

import re
from pathlib import PurePosixPath
from typing import Any

from paths import PAGES

_ITEM = re.compile(r"\]\((\S+?\.md)(?:#\S*)?\)")


def navigation(reference: list[str]) -> list[Any]:
    """Return the navigation in the form of ``nav`` in ``mkdocs.yml``.

    Args:
        reference: the pages of the API reference.
    """
    sections = _sections((PAGES / "contents.md").read_text())
    sections["Reference"].append({"Python modules": reference})
    project = ["readme.md", "contributing.md", "changelog.md"]
    tabs = [{title: pages} for title, pages in sections.items()]
    return [{"Home": "index.md"}, *tabs, {"Gallery": "gallery.md"}, {"Project": ["contents.md", *project]}]


def _sections(contents: str) -> dict[str, list[Any]]:
    """Return the pages that each section of the contents page links to, in groups where it has any."""
    sections: dict[str, list[Any]] = {}
    pages: list[Any] = []
    seen: set[str] = set()
    for line in contents.splitlines():
        if line.startswith("## "):
            pages = sections[line[3:].strip()] = []
        elif re.match(r"\w[^\[]*$", line) and sections:
            group: list[Any] = []
            sections[next(reversed(sections))].append({line.strip(): group})
            pages = group
        for page in _ITEM.findall(line):
            if page not in seen and not page.startswith("source/"):
                seen.add(page)
                pages.append(_with_children(page))
    return sections


def _with_children(page: str) -> Any:
    """Return a page, and with the index of a folder the pages beside it."""
    if PurePosixPath(page).name != "index.md":
        return page
    folder = (PAGES / page).parent
    children = sorted(path.relative_to(PAGES).as_posix() for path in folder.glob("[0-9]*.md"))
    return {folder.name.capitalize(): [page, *children]}
