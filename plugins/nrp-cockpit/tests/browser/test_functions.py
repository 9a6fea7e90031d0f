"""Transfer functions are read, edited, applied and switched while a run goes on."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from browsing import Watched, seen
from playwright.sync_api import Page, expect
from visitors import cockpit

"""The first check of an experiment reads and compiles it."""
MISTAKE = "did you mean 'rate'?"


def functions(page: Page, file: str) -> None:
    """Open a file in the view of the functions."""
    page.get_by_role("link", name="Functions", exact=True).click()
    page.get_by_role("tab", name=file).click()


def end_of_line(page: Page, text: str) -> None:
    """Put the cursor behind a line."""
    page.locator(".cm-line", has_text=text).click()
    page.keyboard.press("End")


def test_typed_functions_are_checked_and_a_wrong_text_is_not_applied(husky: str, watched: Watched):
    page = watched.open(husky)
    functions(page, "listing2.py")
    end_of_line(page, "red_right_eye.rate")
    page.keyboard.type("\nred_right_eye.rates = 1.0")
    line = page.locator(".cm-line", has_text="red_right_eye.rates")
    expect(line).to_contain_text(MISTAKE)
    expect(page.get_by_role("region", name="Findings")).to_contain_text("NRP240")
    page.keyboard.press("Control+Enter")
    expect(page.get_by_text("Not applied:")).to_be_visible()
    expect(page.get_by_role("tab", name="listing2.py")).to_contain_text("edited")
    page.get_by_role("button", name="Discard").click()
    expect(line).to_have_count(0)
    expect(page.get_by_text("No file is edited.")).to_be_visible()


@pytest.mark.heavy
def test_an_edit_outlives_the_view_is_compared_and_runs_once_applied(husky: str, watched: Watched):
    page = watched.open(husky)
    functions(page, "listing2.py")
    end_of_line(page, "red_right_eye.rate")
    page.keyboard.type(" * 0.5")
    page.get_by_role("link", name="Cockpit").click()
    functions(page, "listing2.py")
    page.get_by_role("radio", name="Changes").click()
    expect(page.locator(".cm-merge-a .cm-changedLine")).not_to_contain_text("* 0.5")
    expect(page.locator(".cm-merge-b .cm-changedLine")).to_contain_text("* 0.5")
    page.get_by_role("radio", name="Edit").click()
    page.get_by_role("button", name="Apply").click()
    expect(page.get_by_text("No file is edited.")).to_be_visible()
    page.get_by_role("button", name="Step", exact=True).click()
    expect(page.get_by_role("timer")).to_contain_text("0.02 s")
    second = watched.open(page.url)  # another page has what runs
    functions(second, "listing2.py")
    expect(second.locator(".cm-line", has_text="* 0.5")).to_be_visible()


def test_the_editor_proposes_the_names_of_the_experiment(husky: str, watched: Watched):
    page = watched.open(husky)
    functions(page, "listing2.py")
    end_of_line(page, "red_right_eye.rate")
    page.keyboard.type("\nnrp.brain.sen", delay=40)
    page.get_by_role("option", name="nrp.brain.sensors").click()
    expect(page.locator(".cm-line", has_text="nrp.brain.sensors").last).to_be_visible()


def test_a_function_is_switched_off_and_on(husky: str, watched: Watched):
    page = watched.open(husky)
    functions(page, "listing1.py")
    switch = page.get_by_role("switch", name="linear_twist runs")
    expect(switch).to_be_checked()
    switch.click()
    expect(switch).not_to_be_checked()
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Step", exact=True).click()
    expect(page.get_by_role("listitem").filter(has=switch)).to_contain_text("off")
    page.get_by_role("link", name="Cockpit").click()
    value = page.get_by_role("region", name="voltage (mV)").get_by_role("listitem").first
    expect(value).to_have_text("left_wheel_neuronoff")
    page.get_by_role("contentinfo").get_by_role("link", name="1 function switched off").click()
    switch.click()
    expect(switch).to_be_checked()


def test_a_function_in_quarantine_unfolds_its_traceback(
    in_process: Callable[..., str], watched: Watched, broken: Path
):
    page = watched.open(in_process("on_error=quarantine", experiment=str(broken)))
    page.get_by_role("button", name="Step", exact=True).click()
    functions(page, "broken.py")
    row = page.get_by_role("listitem").filter(has=page.get_by_role("switch", name="divides runs"))
    expect(row).to_contain_text("quarantine")
    row.get_by_text("ZeroDivisionError: division by zero").first.click()
    expect(row.get_by_text("Traceback (most recent call last):")).to_be_visible()


def test_a_file_is_saved_to_the_disk_only_when_asked(
    in_process: Callable[..., str], watched: Watched, broken: Path
):
    file = broken.with_name("broken.py")
    before = file.read_text()
    page = watched.open(in_process(experiment=str(broken)))
    functions(page, "broken.py")
    end_of_line(page, "def divides")
    page.keyboard.type("\nreturn")
    expect(page.get_by_text("1 file is edited.")).to_be_visible()
    assert file.read_text() == before
    page.get_by_role("button", name="Save", exact=True).click()
    expect(page.get_by_text("Saved broken.py.")).to_be_visible()
    assert "return" in file.read_text()


def test_a_misspelt_name_is_mended_by_a_click_or_a_key_and_that_can_be_undone(husky: str, watched: Watched):
    page = watched.open(husky)
    functions(page, "listing2.py")
    end_of_line(page, "red_right_eye.rate")
    page.keyboard.type("\nred_right_eye.rates = 1.0")
    wrong = page.locator(".cm-line", has_text="red_right_eye.rates")
    mended = page.locator(".cm-line", has_text="red_right_eye.rate = 1.0")
    wrong.get_by_role("button", name="Replace with rate").click()
    expect(mended).to_be_visible()
    expect(page.get_by_text(MISTAKE)).to_have_count(0)
    mended.click()
    page.keyboard.press("Control+z")
    expect(wrong).to_contain_text(MISTAKE)
    page.keyboard.press("Control+.")
    expect(mended).to_be_visible()
    page.keyboard.press("Control+z")
    row = page.get_by_role("region", name="Findings").get_by_role("listitem").filter(has_text=MISTAKE)
    row.get_by_role("button", name="Replace with rate").click()
    expect(mended).to_be_visible()
    page.keyboard.press("Control+Enter")
    expect(page.get_by_text("No file is edited.")).to_be_visible()


def test_a_function_that_stopped_the_run_is_marked_and_linked_to_its_line(
    in_process: Callable[..., str], watched: Watched, broken: Path
):
    page = watched.open(in_process("on_error=stop", experiment=str(broken)))
    page.get_by_role("button", name="Step", exact=True).click()
    functions(page, "listing1.py")
    row = page.get_by_role("listitem").filter(has=page.get_by_role("switch", name="divides runs"))
    expect(row).to_contain_text("stopped the run")
    expect(row).to_contain_text("ZeroDivisionError: division by zero")
    page.get_by_role("region", name="Findings").get_by_role("button", name="broken.py:5").click()
    expect(page.get_by_role("tab", name="broken.py")).to_have_attribute("aria-selected", "true")
    expect(page.locator(".cm-line", has_text="1 / len")).to_contain_text("ZeroDivisionError")


def test_the_second_editor_of_a_file_is_warned_before_it_is_overwritten(husky: str, watched: Watched):
    first, second = watched.open(husky), watched.open(husky)
    for page, factor in ((first, "0.5"), (second, "0.25")):
        functions(page, "listing2.py")
        end_of_line(page, "red_right_eye.rate")
        page.keyboard.type(f" * {factor}")
        expect(page.get_by_text("1 file is edited.")).to_be_visible()
    expect(first.get_by_text("2 in control", exact=True)).to_be_visible()
    first.get_by_role("button", name="Apply").click()
    expect(first.get_by_text("No file is edited.")).to_be_visible()
    expect(second.get_by_text("Somebody else changed listing2.py")).to_be_visible()
    second.keyboard.press("Control+Enter")
    expect(second.get_by_text("Not applied: somebody else has changed listing2.py")).to_be_visible()
    expect(first.locator(".cm-line", has_text="* 0.5")).to_be_visible()
    second.get_by_role("button", name="Keep mine").click()
    second.get_by_role("button", name="Apply").click()
    expect(first.locator(".cm-line", has_text="* 0.25")).to_be_visible()


def test_the_page_shows_watchers_and_wrong_tokens_their_rights(watched: Watched):
    with cockpit() as opened:
        guard, address = opened.guard, opened.address
        page = watched.open(address.replace(guard.token, guard.watch_token), ready=("heading", "Spikes"))
        expect(page.get_by_text("Watching only")).to_be_visible()
        expect(page.get_by_role("button", name="Reset", exact=True)).to_be_disabled()
        stranger = watched.open(address.replace(guard.token, "guessed"), ready=("heading", "No access"))
        expect(stranger.get_by_text("the token is missing or wrong; use the printed address")).to_be_visible()
        expect(stranger.get_by_text("Reconnecting")).to_have_count(0)
        assert any("401" in each for each in watched.complaints)  # the browser reports it too
        watched.complaints.clear()


def test_a_slider_changes_the_number_at_the_cursor_while_the_run_goes_on(watched: Watched) -> None:
    with cockpit(experiment="braitenberg_husky/mixed_levels") as opened:
        names = {Path(file).name: file for file in opened.session.functions.files}
        model, python = (next(name for name in names if name.endswith(end)) for end in (".bibi", ".py"))
        page = watched.open(opened.address)
        page.get_by_role("button", name="Play").click()
        numbers = page.get_by_role("list", name="Number at the cursor")
        for name, line, back, before, after in (
            (model, 'factor="20"', 2, 'factor="20"', 'factor="0.0"'),
            (python, "red_left_eye.rate", len(" * image_results.leftred"), "= 1000.0 *", "= 0.0 *"),
        ):
            functions(page, name)
            expect(numbers).to_have_count(0)
            page.locator(".cm-line", has_text=line).first.click()
            page.keyboard.press("End")
            for _ in range(back):
                page.keyboard.press("ArrowLeft")
            slider = numbers.get_by_role("slider")
            expect(slider).to_have_attribute(
                "aria-valuetext", f"{re.sub('[^0-9.]', '', before).removesuffix('.0')} "
            )
            slider.press("Home")  # the least value
            running = seen(
                page,
                lambda name=name: opened.session.functions.texts[names[name]],
                lambda text, after=after: after in text,
            )
            assert running == Path(names[name]).read_text().replace(before, after, 1)
            expect(page.get_by_text("No file is edited.")).to_be_visible()
            expect(slider).to_have_attribute("aria-valuetext", "0 ")
        expect(page.get_by_role("button", name="Pause")).to_be_visible()
        assert not opened.run.loop.failures
