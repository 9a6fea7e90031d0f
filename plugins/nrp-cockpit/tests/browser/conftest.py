"""A cockpit in its own process, and a page of it in Debian's Chromium."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

PACKAGE = Path(__file__).parents[2]
CHROMIUM = (
    "--no-sandbox",
    "--use-angle=swiftshader",  # WebGL without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-quic",
    "--no-first-run",
)

Open = Callable[..., str]


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=list(CHROMIUM))
        yield browser
        browser.close()


class Cockpits:
    """Starts cockpits, and ends them."""

    def __init__(self) -> None:
        self.running: list[subprocess.Popen[str]] = []

    def open(self, experiment: str, *options: str) -> str:
        """Return the address of a new cockpit: the first line of its standard output."""
        command = [sys.executable, "-m", "nrp_core", "cockpit", experiment, "--no-browser", *options]
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=dict(os.environ)
        )
        self.running.append(process)
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        assert address.startswith("http://127.0.0.1:"), address
        return address

    def close(self) -> None:
        """Interrupt all, as Ctrl-C does; each must end well."""
        for process in self.running:
            process.send_signal(signal.SIGINT)
        codes = [process.wait(20) for process in self.running]
        self.running.clear()
        assert set(codes) <= {0}


@pytest.fixture
def cockpits() -> Iterator[Cockpits]:
    cockpits = Cockpits()
    yield cockpits
    cockpits.close()


class Watched:
    """Opens pages of one browser and notes what they ask for and complain about."""

    def __init__(self, browser: Browser) -> None:
        self._browser = browser
        self.complaints: list[str] = []
        self.outside: list[str] = []

    def open(self, address: str, width: int = 1440, height: int = 900) -> Page:
        """Return a new page, in a visit of its own, that shows an experiment."""
        context = self._browser.new_context(viewport={"width": width, "height": height})
        page = context.new_page()
        home = urlsplit(address).netloc
        page.on("console", lambda said: said.type == "error" and self.complaints.append(said.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on(
            "request",
            lambda asked: urlsplit(asked.url).netloc not in (home, "") and self.outside.append(asked.url),
        )
        page.goto(address)
        page.get_by_role("button", name="Play").wait_for()
        return page


@pytest.fixture
def watched(browser: Browser) -> Iterator[Watched]:
    """Pages that must neither complain nor ask anybody outside."""
    watched = Watched(browser)
    yield watched
    assert watched.complaints == []
    assert watched.outside == []
    for context in browser.contexts:
        context.close()
