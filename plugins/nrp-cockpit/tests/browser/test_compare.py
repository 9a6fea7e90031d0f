"""Two runs beside each other in one page, in step: another future, and other engines."""

from __future__ import annotations

import pytest
from browsing import CUT, HUSKY, Kept, Watched, seen, wait_until
from playwright.sync_api import FrameLocator, Page, expect
from stories import FONTS, STYLED, Stories, settled

EVENT = ("-s", "events.left_red.at=0.2 s")


def frame(page: Page, title: str) -> FrameLocator:
    return page.frame_locator(f"iframe[title='{title}']")


def test_a_branch_is_changed_and_the_difference_is_shown(kept: Kept, watched: Watched, stories: Stories):
    page = watched.open(kept.open("braitenberg_husky", *HUSKY, *EVENT), 1280, 720)
    page.get_by_role("slider", name="Simulated time").press("PageUp")
    expect(page.get_by_role("timer")).to_contain_text("1.00 s")
    page.keyboard.press("b")
    verdict = page.get_by_role("region", name="Difference").get_by_role("status")
    expect(verdict).to_contain_text("Identical since 1.00 s")
    for title in ("The run", "Branch of 1.00 s"):
        expect(frame(page, title).get_by_role("region", name="Scene")).to_be_visible()
    for width, height in ((1280, 720), (640, 360)):  # and at 200 % of it
        page.set_viewport_size({"width": width, "height": height})
        for title in ("The run", "Branch of 1.00 s"):
            heads = frame(page, title).locator(".panel-head")
            seen(page, lambda heads=heads: heads.evaluate_all(CUT), lambda cut: cut == [])  # type: ignore[misc]
    page.set_viewport_size({"width": 1280, "height": 720})
    page.evaluate(STYLED, FONTS)
    page.get_by_role("button", name="Switch between light and dark").click()
    for title in ("The run", "Branch of 1.00 s"):
        expect(frame(page, title).locator("html")).to_have_class("theme-dark")
    page.get_by_role("button", name="Step", exact=True).click()
    expect(page.get_by_role("timer")).to_contain_text("1.02 s")
    expect(verdict).to_contain_text("Identical since 1.00 s")
    selected = frame(page, "Branch of 1.00 s").get_by_role("region", name="Selected")
    selected.get_by_role("button", name="husky", exact=True).click()
    selected.get_by_role("textbox", name="x (m)").fill("1.5")
    selected.get_by_role("button", name="Place", exact=True).click()
    page.get_by_role("button", name="Step", exact=True).click()
    expect(verdict).to_contain_text("The robot's path differs first, at 1.04 s")
    lane = page.get_by_role("list", name="Differences from Branch of 1.00 s")
    expect(lane.get_by_role("button", name="The robot's path differs from 1.04 s: go there")).to_be_visible()
    expect(lane.get_by_text("apart", exact=False).first).to_be_attached()
    page.get_by_role("slider", name="Simulated time").press("PageUp")
    expect(page.get_by_role("timer")).to_contain_text("2.04 s")
    panels = {
        "difference": page.get_by_role("region", name="Difference"),
        "timeline": page.locator("[data-panel=timeline]"),
    }
    stories.compare("compare", settled(page, panels))
    page.get_by_role("button", name="Close the second run").click()
    expect(lane).to_have_count(0)
    expect(page.get_by_role("region", name="Comparison")).to_be_visible()


@pytest.mark.heavy
def test_another_pair_of_engines_is_chosen_in_the_page_and_goes_in_step(kept: Kept, watched: Watched):
    page = watched.open(kept.open("braitenberg_husky", *HUSKY, *EVENT))
    page.get_by_role("link", name="Compare", exact=True).click()
    choice = page.get_by_role("region", name="Comparison")
    choice.get_by_label("World").select_option("pybullet")
    choice.get_by_role("button", name="Compare from 0 s").click()
    expect(page.get_by_title("event + pybullet")).to_be_visible()
    page.get_by_role("button", name="Step", exact=True).click()
    table = page.get_by_role("region", name="Difference").get_by_role("table").filter(has_text="Events")
    expect(table.get_by_role("columnheader", name="event + mujoco")).to_be_visible()
    page.get_by_role("button", name="Play").click()
    wait_until(page, 0.6)
    page.get_by_role("button", name="Pause").click()
    expect(table.get_by_role("row", name="left_red")).to_contain_text("0.20 s")
