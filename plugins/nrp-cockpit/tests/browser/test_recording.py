"""A recording is played in the page of runs."""

from __future__ import annotations

from pathlib import Path

from browsing import Cockpits, Watched, wait_until
from playwright.sync_api import expect


def test_a_recording_is_played_and_shown_at_any_time(recording: Path, cockpits: Cockpits, watched: Watched):
    page = watched.open(cockpits.open(str(recording)))
    timer = page.get_by_role("timer")
    page.get_by_role("slider", name="Pace").press("Home")  # on a busy machine two seconds are soon over
    page.get_by_role("button", name="Play").click()
    wait_until(page, 0.1)
    page.get_by_role("button", name="Pause").click()
    slider = page.get_by_role("slider", name="Simulated time")
    slider.press("Home")
    expect(timer).to_contain_text("0.00 s")
    slider.press("PageUp")
    expect(timer).to_contain_text("1.00 s")
    page.get_by_role("button", name="Step back").click()
    expect(timer).to_contain_text("0.98 s")
    slider.press("End")
    expect(timer).to_contain_text("2.00 s")
    expect(page.get_by_role("button", name="Play")).to_be_disabled()
    expect(page.get_by_role("button", name="Record")).to_have_count(0)
