"""Checks of the built site: every link leads somewhere, and nothing is loaded from elsewhere."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

_LOADS = {"script": "src", "img": "src", "iframe": "src", "source": "src", "video": "src"}
_LOADED_RELS = {"stylesheet", "preconnect", "preload", "icon", "prefetch"}


@dataclass
class _Page(HTMLParser):
    """The links, anchors and loads of an HTML page."""

    links: set[str] = field(default_factory=set)
    loads: set[str] = field(default_factory=set)
    anchors: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value for name, value in attrs if value}
        self.anchors |= {values[name] for name in ("id", "name") if name in values}
        if tag == "a" and "href" in values:
            self.links.add(values["href"])
        if tag in _LOADS and _LOADS[tag] in values:
            self.loads.add(values[_LOADS[tag]])
        if tag == "link" and "href" in values and _LOADED_RELS & set(values.get("rel", "").split()):
            self.loads.add(values["href"])


def faults(site: Path) -> list[str]:
    """Return a sentence for each link that leads nowhere and each file that is loaded from elsewhere."""

    @cache
    def parsed(file: Path) -> _Page:
        page = _Page()
        page.feed(file.read_text())
        return page

    found = []
    for file in sorted(site.rglob("*.html")):
        if file.name == "404.html":
            continue  # its links begin at the address of the site, which a build does not know
        name = file.relative_to(site)
        page = parsed(file)
        found += [f"{name}: loads {url}" for url in sorted(page.loads) if urlsplit(url).netloc]
        for url in sorted(page.links | page.loads):
            parts = urlsplit(url)
            if parts.scheme or parts.netloc:
                continue
            target = file if not parts.path else Path(os.path.normpath(file.parent / unquote(parts.path)))
            target = target / "index.html" if target.is_dir() else target
            if not target.is_file():
                found.append(f"{name}: links to {url}, and there is no such file")
            elif parts.fragment and target.suffix == ".html" and not _has(parsed(target), parts.fragment):
                found.append(f"{name}: links to {url}, and the page has no such heading")
    return found


def _has(page: _Page, fragment: str) -> bool:
    return unquote(fragment) in page.anchors or fragment.startswith("__")
