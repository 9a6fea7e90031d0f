"""A run that is watched for long fills neither the memory of the server nor that of the page."""

from __future__ import annotations

from pathlib import Path

import pytest
from browsing import HUSKY, Cockpits, Watched, wait_until
from playwright.sync_api import CDPSession, Page

WARM_S, LONG_S = 120, 600
EVERY_S = 30
MOST_MB_OF_SERVER, MOST_MB_OF_PAGE = 4.0, 2.0
"""By which they may grow after two minutes, in which plots fill their windows and caches their room: less
than half a megabyte a minute."""


def server_mb(cockpits: Cockpits) -> float:
    """Return the memory that the server holds, MB."""
    (process,) = cockpits.running
    status = Path(f"/proc/{process.pid}/status").read_text()
    kilobytes = next(line.split()[1] for line in status.splitlines() if line.startswith("VmRSS"))
    return int(kilobytes) / 1e3


def page_mb(devtools: CDPSession) -> float:
    """Return the memory of the objects of the page that are in use, MB."""
    devtools.send("HeapProfiler.collectGarbage")
    return float(devtools.send("Runtime.getHeapUsage")["usedSize"]) / 1e6


def grown(page: Page, cockpits: Cockpits) -> list[tuple[float, float, float]]:
    """Return simulated time, s, and what server and page hold, MB, each half minute."""
    devtools = page.context.new_cdp_session(page)
    samples = []
    for t_s in range(EVERY_S, LONG_S + 1, EVERY_S):
        wait_until(page, t_s, timeout_ms=20 * 60_000)
        samples.append((float(t_s), server_mb(cockpits), page_mb(devtools)))
        print("at {:.0f} s the server holds {:.1f} MB, the page {:.2f} MB".format(*samples[-1]), flush=True)
    return samples


@pytest.mark.heavy
def test_ten_minutes_of_a_run_leave_the_memory_flat(cockpits: Cockpits, watched: Watched):
    page = watched.open(
        cockpits.open("braitenberg_husky", *HUSKY, "-s", "duration=700 s"), width=1280, height=720
    )
    page.get_by_role("button", name="Play").click()
    samples = [each for each in grown(page, cockpits) if each[0] >= WARM_S]
    (_, server_before, page_before), (_, server_after, page_after) = samples[0], samples[-1]
    assert server_after - server_before < MOST_MB_OF_SERVER, samples
    assert page_after - page_before < MOST_MB_OF_PAGE, samples
