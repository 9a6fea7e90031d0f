"""A page shows the past of a run however late it is opened, and never a number that it does not know."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from browsing import UNKNOWN, Watched, seen
from playwright.sync_api import Page, expect
from visitors import SMALL, Cockpit, cockpit

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

Count = Callable[[float], int]


@pytest.fixture(scope="module")
def count() -> Count:
    """Return how many spikes the same run without a cockpit has in the second before a time."""
    with Run(load_experiment("braitenberg_husky", [SMALL])) as run:
        neurons = np.arange(run.brain.network.size)
        port = run.brain.add_sink(SpikeRecorder(keep_ms=60_000.0), neurons, name="test")
        run.run_until(4.5)
    return lambda t_s: len(port.spikes((t_s - 1) * 1000, t_s * 1000))


@pytest.fixture(scope="module")
def opened() -> Iterator[Cockpit]:
    with cockpit() as opened:
        yield opened


@pytest.fixture
def run(opened: Cockpit) -> Cockpit:
    """A run at its beginning."""
    opened.session.ask(opened.session.reset)
    return opened


def shows(page: Page, count: int) -> None:
    """Wait until the spikes of the last second are this many, and the rates of all cells fit."""
    assert count > 50
    expect(page.get_by_role("region", name="Spikes")).to_contain_text(f"{count} in 1 s")

    def total() -> float:
        rates = page.locator(".brain-rate").all_text_contents()
        return sum(float(text.removesuffix(" Hz")) for text in rates if UNKNOWN not in text)

    seen(page, total, lambda hz: abs(hz - count) <= 4)  # each of eight is rounded to 1 Hz


def go(run: Cockpit, t_s: float) -> None:
    run.session.ask(lambda: run.session.seek(t_s))


def test_the_page_knows_what_happened_while_another_view_was_open(
    run: Cockpit, watched: Watched, count: Count
) -> None:
    page = watched.open(run.address)
    go(run, 1.0)
    page.get_by_role("link", name="Functions", exact=True).click()
    expect(page.get_by_role("img", name="Spikes of circuit")).to_have_count(0)
    go(run, 3.5)
    page.get_by_role("link", name="Cockpit", exact=True).click()
    shows(page, count(3.5))


def test_a_page_that_is_opened_late_or_again_shows_spikes_curves_and_the_image(
    run: Cockpit, watched: Watched, count: Count
) -> None:
    first = watched.open(run.address)
    go(run, 2.0)
    for page in (watched.open(run.address), first):
        if page is first:
            page.reload()
        shows(page, count(2.0))
        expect(page.get_by_role("img", name="The image of /husky/camera")).to_be_visible()
        for value in page.locator(".trace-key b").all():
            expect(value).to_have_text(re.compile(r"\d"))


def test_a_jump_shows_the_values_of_that_time(run: Cockpit, watched: Watched, count: Count) -> None:
    page = watched.open(run.address)
    go(run, 4.0)
    shows(page, count(4.0))
    go(run, 2.0)
    page.reload()  # else the page knows it itself
    expect(page.get_by_role("timer")).to_contain_text("2.00 s")
    shows(page, count(2.0))
    expect(page.get_by_role("img", name="The image of /husky/camera")).to_be_visible()


def test_a_reset_shows_no_image_of_the_future(run: Cockpit, watched: Watched) -> None:
    page = watched.open(run.address)
    go(run, 1.0)
    image = page.get_by_role("img", name="The image of /husky/camera")
    expect(image).to_be_visible()
    run.session.ask(run.session.reset)
    expect(page.get_by_text("Waiting for /husky/camera")).to_be_visible()
    expect(image).to_be_hidden()


def test_rates_are_not_given_where_nothing_was_recorded(run: Cockpit, watched: Watched) -> None:
    run.session.ask(run.session.stream.close)  # as some time after the last page was closed
    go(run, 3.0)
    page = watched.open(run.address)
    rates = page.locator(".brain-rate")
    expect(rates).to_have_text([f"{UNKNOWN} Hz"] * 8)
    expect(page.get_by_role("region", name="Spikes")).to_contain_text(f"{UNKNOWN} in 1 s")
    go(run, 4.1)
    expect(rates.first).to_have_text(re.compile(r"\d Hz"))
