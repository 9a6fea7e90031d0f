"""The timeline: to a later time, back in time, to a snapshot, and to the function that stopped a run."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from browsing import Watched, box_of, time_s, wait_until
from playwright.sync_api import Page, expect


def paused_at(page: Page, t_s: float) -> None:
    """Wait until a run stands at a time."""
    expect(page.get_by_role("timer")).to_contain_text(f"{t_s:.2f} s")
    expect(page.get_by_role("button", name="Play")).to_be_enabled()


def ready(page: Page) -> Page:
    """Wait until the page knows the run, before which it ignores clicks."""
    expect(page.get_by_role("button", name="Reset", exact=True)).to_be_enabled()
    return page


def test_a_click_on_the_timeline_runs_to_a_later_time_and_goes_back_to_an_earlier_one(
    husky: str, watched: Watched
):
    page = ready(watched.open(husky))
    slider = page.get_by_role("slider", name="Simulated time")
    box = box_of(slider)
    lane = box["y"] + 1.5 * box["height"]
    page.mouse.click(box["x"] + box["width"] * 0.05, lane)  # 2 s of 40 s
    wait_until(page, 1.9)
    expect(page.get_by_role("button", name="Play")).to_be_enabled()
    there = time_s(page)
    page.mouse.click(box["x"] + box["width"] * 0.02, lane)
    expect(page.get_by_role("timer")).to_contain_text("0.8")
    assert time_s(page) < there


@pytest.mark.heavy
def test_the_arrows_of_the_timeline_move_a_run(husky: str, watched: Watched):
    page = ready(watched.open(husky))
    slider = page.get_by_role("slider", name="Simulated time")
    slider.press("PageUp")
    paused_at(page, 1.0)
    slider.press("ArrowLeft")
    paused_at(page, 0.9)
    slider.press("Home")
    paused_at(page, 0.0)


@pytest.mark.heavy
def test_a_snapshot_stands_on_the_timeline_and_a_click_restores_it(husky: str, watched: Watched):
    page = ready(watched.open(husky))
    page.get_by_role("slider", name="Simulated time").press("PageUp")
    paused_at(page, 1.0)
    page.get_by_role("button", name="Take a snapshot").click()
    snapshot = page.get_by_role("button", name="Restore the snapshot of 1.00 s")
    snapshot.wait_for()
    page.get_by_role("button", name="Step", exact=True).click()
    paused_at(page, 1.02)
    snapshot.click()
    paused_at(page, 1.0)
    expect(page.get_by_text(re.compile(r"Restored the snapshot of 1\.00 s in \d+\.\d\d s\."))).to_be_visible()


def test_an_error_says_where_the_run_stopped_and_opens_the_function(
    in_process: Callable[..., str], watched: Watched, broken: Path
):
    page = ready(watched.open(in_process(experiment=str(broken))))
    page.get_by_role("button", name="Play").click()
    banner = page.get_by_role("alert").filter(has_text="ZeroDivisionError")
    expect(banner).to_contain_text("broken.py:5")
    expect(page.get_by_text("failed", exact=True)).to_be_visible()
    banner.get_by_role("button", name="Open function").click()
    expect(page.get_by_role("tab", name="broken.py")).to_have_attribute("aria-selected", "true")
    expect(page.locator(".cm-activeLine")).to_contain_text("1 / len(")


@pytest.mark.heavy
def test_a_drag_through_a_recording_shows_the_times_that_it_passes(played: str, watched: Watched):
    page = ready(watched.open(played))
    box = box_of(page.get_by_role("slider", name="Simulated time"))
    page.mouse.move(box["x"] + 0.1 * box["width"], box["y"] + 5)
    page.mouse.down()
    passed = []
    for share in (0.2, 0.3, 0.4, 0.5):
        page.mouse.move(box["x"] + share * box["width"], box["y"] + 5)
        page.wait_for_function(
            "t => document.querySelector('[role=timer]').innerText.startsWith(t)", arg=f"{share * 2:.1f}"
        )
        passed.append(time_s(page))
    page.mouse.up()
    assert passed == sorted(passed)
    page.get_by_role("link", name="Functions", exact=True).click()
    expect(page.get_by_text("This is a recording")).to_be_visible()


@pytest.mark.heavy
def test_an_intervention_during_the_run_stands_on_the_timeline_and_a_click_goes_there(
    in_process: Callable[..., str], watched: Watched
):
    interventions = "[{lesion: actors, at: 8 s}, {silence: sensors}, {lesion: sensors, at: 50 s}]"
    page = ready(
        watched.open(in_process(f"brain.interventions={interventions}", experiment="braitenberg_husky"))
    )
    lane = page.get_by_role("list", name="Events")
    mark = lane.get_by_role("button", name="Intervention lesion_actors at 8.00 s: go there")
    expect(lane.get_by_role("button", name="Intervention")).to_have_count(1)
    track = box_of(page.get_by_role("slider", name="Simulated time"))
    assert box_of(mark)["x"] - track["x"] == pytest.approx(8 / 40 * track["width"], abs=6)
    mark.click()
    paused_at(page, 8.0)
