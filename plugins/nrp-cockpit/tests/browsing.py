"""Cockpits in processes of their own, and pages of them."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar
from urllib.parse import urlsplit

from playwright.sync_api import Browser, FloatRect, Locator, Page, expect, sync_playwright
from visitors import PATIENCE_S, RefusedError, Visitor
from websockets.sync.client import connect

CHROMIUM = (
    "--no-sandbox",
    "--use-angle=swiftshader",  # WebGL without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",  # all else is drawn without WebGL, at half the cost
    "--disable-accelerated-2d-canvas",
    "--disable-background-networking",
    "--disable-quic",
    "--no-first-run",
    "--font-render-hinting=none",  # letters as on any machine
    "--disable-lcd-text",
    "--force-color-profile=srgb",
)

PATIENCE_MS = 1000 * PATIENCE_S
"""The longest time that a page may take; what is there already is not waited for."""

CUT = """heads => heads.flatMap(head => {
    const box = head.getBoundingClientRect();
    return [...head.querySelectorAll("h2, button, select, input")].filter(one => {
        const { left, right, top, bottom, width } = one.getBoundingClientRect();
        const sideways = left < box.left - 1 || right > box.right + 1;
        return width > 0 && (sideways || top < box.top - 1 || bottom > box.bottom + 1);
    }).map(one => `${head.innerText}: ${one.innerText || one.getAttribute("aria-label")}`);
})"""
"""Gives the titles and tools that reach out of the heads of their panels."""

HUSKY = ("-s", "world.options.image_scale=0.25")
UNKNOWN = "\N{EN DASH}"
"""What the page shows in place of a number that nobody knows."""
T = TypeVar("T")


@contextmanager
def chromium() -> Iterator[Browser]:
    """Give Debian's Chromium."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=list(CHROMIUM))
        yield browser
        browser.close()


def time_s(page: Page) -> float:
    """Return the simulated time that the page shows."""
    shown = page.get_by_role("timer").inner_text()
    return float(re.match(r"\s*([\d.]+) s", shown).group(1))  # type: ignore[union-attr]


def wait_until(page: Page, t_s: float, timeout_ms: float = PATIENCE_MS) -> None:
    page.wait_for_function(
        "t => parseFloat(document.querySelector('[role=timer]')?.innerText) >= t", arg=t_s, timeout=timeout_ms
    )


def seen(page: Page, look: Callable[[], T], fits: Callable[[T], Any] = bool) -> T:
    """Look again until what is seen fits, and return it: a page draws some frames after it is told."""
    end_s = time.monotonic() + PATIENCE_S
    while not fits(found := look()):
        assert time.monotonic() < end_s, f"still seen: {found}"
        page.wait_for_timeout(50)
    return found


def drawn(page: Page) -> None:
    """Wait until the scene is drawn as it is looked at now: a click hits what the last picture shows."""
    page.wait_for_function("() => performance.getEntriesByName('first-picture').length > 0")
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def box_of(one: Locator) -> FloatRect:
    """Return where something is as soon as it stands still, in pixels of the page."""
    one.scroll_into_view_if_needed()
    box = one.bounding_box()
    assert box is not None
    return box


class Cockpits:
    """Starts cockpits, and ends them."""

    def __init__(self) -> None:
        self.running: list[subprocess.Popen[str]] = []

    def open(self, *words: str) -> str:
        """Return the address of a new cockpit: of an experiment with options, or of its start page."""
        return self._serve("cockpit", *words)

    def design(self, file: str, *options: str) -> str:
        """Return the address of a new designer."""
        return self._serve("design", file, *options)

    def _serve(self, *words: str) -> str:
        """Start a command and return the address that is the first line of its standard output."""
        command = [sys.executable, "-m", "nrp_core", *words, "--no-browser"]
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=dict(os.environ)
        )
        self.running.append(process)
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        assert address.startswith("http://"), address
        return address

    def close(self) -> None:
        """End all as Ctrl-C does, which a shell in the background would ignore; each must end well."""
        for process in self.running:
            process.send_signal(signal.SIGTERM)
        codes = [process.wait(PATIENCE_S) for process in self.running]
        for process in self.running:
            process.communicate()  # closes its pipe
        self.running.clear()
        assert set(codes) <= {0}


@contextmanager
def running() -> Iterator[Cockpits]:
    """Give cockpits that end with the block, also when it fails."""
    cockpits = Cockpits()
    try:
        yield cockpits
    finally:
        cockpits.close()


class Pages:
    """Pages in visits of their own that are used again, at half the cost of a new one."""

    def __init__(self, browser: Browser) -> None:
        self._browser = browser
        self._free: list[Page] = []

    def take(self) -> Page:
        if self._free:
            return self._free.pop()
        context = self._browser.new_context()
        context.set_default_timeout(PATIENCE_MS)
        return context.new_page()

    def give_back(self, page: Page) -> None:
        """Leave a page, and forget what it kept."""
        page.evaluate("() => { localStorage.clear(); sessionStorage.clear(); }")
        page.goto("about:blank")
        self._free.append(page)


class Watched:
    """Opens pages and notes what they ask for and complain about."""

    def __init__(self, pages: Pages) -> None:
        self._pages = pages
        self._opened: list[tuple[Page, dict[str, Callable[..., Any]]]] = []
        self.complaints: list[str] = []
        self.outside: list[str] = []

    def open(
        self, address: str, width: int = 1440, height: int = 900, ready: tuple[str, str] = ("button", "Play")
    ) -> Page:
        """Return an empty page as soon as it shows something of this role and name.

        If that is the button that plays, the run can be steered from then on.
        """
        page = self._pages.take()
        page.set_viewport_size({"width": width, "height": height})
        home = urlsplit(address).netloc
        listeners: dict[str, Callable[..., Any]] = {
            "console": lambda said: said.type == "error" and self.complaints.append(said.text),
            "pageerror": lambda error: self.complaints.append(str(error)),
            "request": (
                lambda asked: urlsplit(asked.url).netloc not in (home, "") and self.outside.append(asked.url)
            ),
        }
        for event, listener in listeners.items():
            page.on(event, listener)  # type: ignore[call-overload]
        self._opened.append((page, listeners))
        page.goto(address)
        role, name = ready
        page.get_by_role(role, name=name).wait_for()  # type: ignore[arg-type]
        if name == "Play":
            expect(page.get_by_role("slider", name="Pace")).to_be_enabled()  # also at the end of a run
        return page

    def close(self) -> None:
        """Leave all pages for the next test."""
        for page, listeners in self._opened:
            for event, listener in listeners.items():
                page.remove_listener(event, listener)
            self._pages.give_back(page)
        self._opened.clear()


class Kept:
    """Cockpits that tests use one after the other: each finds its run as if it had just been opened."""

    def __init__(self) -> None:
        self._cockpits = Cockpits()
        self._addresses: dict[tuple[str, ...], str] = {}

    def open(self, experiment: str, *options: str) -> str:
        """Return the address of a cockpit whose run is at its beginning."""
        words = (experiment, *options)
        if words in self._addresses:
            begin_again(self._addresses[words])
        else:
            self._addresses[words] = self._cockpits.open(*words)
        return self._addresses[words]

    def close(self) -> None:
        """End all."""
        self._cockpits.close()


def begin_again(address: str) -> None:
    """Undo all that somebody did to a run."""
    with connect(address.replace("http", "ws", 1), max_size=None, proxy=None) as connection:
        visitor = Visitor(connection)
        visitor.subscribe("/cockpit/timeline", "/cockpit/status")
        visitor.call("pause")
        with suppress(RefusedError):  # mostly there is no second run
            visitor.call("part")
        visitor.call("functions/revert")
        visitor.call("reset", what="all")
        visitor.call("pace", factor=1.0)
        visitor.call("layout/reset")  # a page may have saved one as it was left
        for snapshot in visitor.until(lambda: visitor.last("timeline"))["snapshots"]:
            visitor.call("forget", id=snapshot["id"])
        visitor.status(state="paused", t_s=0.0, pace=1.0)
