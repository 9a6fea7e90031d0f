"""A recording is played in the page of runs."""

from __future__ import annotations

import subprocess
import sys
from ipaddress import ip_address
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from browsing import Watched, wait_until
from playwright.sync_api import expect
from visitors import visit
from websockets.exceptions import InvalidStatus


def test_a_recording_is_played_and_shown_at_any_time(played: str, watched: Watched):
    page = watched.open(played)
    timer = page.get_by_role("timer")
    page.get_by_role("slider", name="Simulated time").press("Home")
    expect(timer).to_contain_text("0.00 s")
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


def test_compare_says_how_a_recording_is_run_again(played: str, watched: Watched, recording: Path):
    page = watched.open(played)
    page.get_by_role("link", name="Compare", exact=True).click()
    expect(page.get_by_role("region", name="Branch")).to_contain_text(f"nrp replay {recording} --from")
    page.get_by_role("link", name="Cockpit", exact=True).click()
    expect(page.get_by_role("region", name="Spikes")).to_be_visible()


def test_two_recordings_are_shown_beside_each_other(played: str, watched: Watched, other_recording: Path):
    page = watched.open(played)
    page.get_by_role("slider", name="Simulated time").press("Home")
    page.get_by_role("link", name="Compare", exact=True).click()
    choice = page.get_by_role("region", name="Comparison")
    choice.get_by_label("Recording").select_option(other_recording.name)
    choice.get_by_role("button", name="Compare", exact=True).click()
    verdict = page.get_by_role("region", name="Difference").get_by_role("status")
    expect(verdict).to_contain_text("Identical since")
    for title in ("husky", other_recording.name):
        frame = page.frame_locator(f"iframe[title='{title}']")
        expect(frame.get_by_role("region", name="Scene")).to_contain_text("11 models")
    page.get_by_role("slider", name="Simulated time").press("End")
    expect(verdict).to_contain_text("differs first, at 0.5")
    row = page.get_by_role("region", name="Difference").get_by_role("row", name="left_red")
    expect(row).to_contain_text("0.50 s")
    expect(row).to_contain_text("1.00 s")
    page.get_by_role("button", name="Close the second run").click()
    expect(choice).to_be_visible()


def test_with_host_and_port_others_may_connect_with_the_token(played: str, port: int, recording: Path):
    address = urlsplit(played)
    assert address.port == port
    assert ip_address(str(address.hostname)), "one that others can reach, if this machine has one"
    other = address._replace(netloc=f"127.0.0.2:{port}")  # as from another machine: by another address
    with visit(other.geturl()) as visitor:
        visitor.subscribe("/cockpit/status")
        visitor.call("seek", t_s=1.5)
        visitor.status(t_s=1.5)
    with pytest.raises(InvalidStatus, match="401"), visit(other._replace(query="token=guessed").geturl()):
        pass
    words = [sys.executable, "-m", "nrp_core", "cockpit", str(recording), "--no-browser", "--port", str(port)]
    second = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (second.returncode, second.stdout) == (3, "")
    assert second.stderr == f"error: cannot listen on 127.0.0.1:{port}: Address already in use\n"
