"""Make the pictures of the cockpit in the documentation.

Run it with the Python of the plugin's environment, ``.venv/plugins/cockpit/bin/python``, which
``scripts/test-plugins cockpit`` makes.
"""

from __future__ import annotations

from pathlib import Path

from browsing import Cockpits, Watched, chromium, wait_until

IMAGES = Path(__file__).parents[3] / "docs" / "images"
SIZE = {"width": 1440, "height": 900}
SEEN_S = 9.0
"""The first screen was reached, and the second is red."""


def main() -> None:
    """Take the pictures."""
    cockpits = Cockpits()
    with chromium() as browser:
        page = Watched(browser).open(cockpits.open("braitenberg_husky"), **SIZE)
        page.get_by_role("button", name="Play").click()
        wait_until(page, SEEN_S)
        page.get_by_role("button", name="Pause").click()
        page.get_by_role("button", name="Play").wait_for()
        page.mouse.move(0, 0)
        page.wait_for_timeout(1000)
        page.screenshot(path=IMAGES / "cockpit.png")
        page.get_by_role("link", name="Functions", exact=True).click()
        page.locator(".cm-content").wait_for()
        page.wait_for_timeout(1000)
        page.screenshot(path=IMAGES / "cockpit-functions.png")
    cockpits.close()


if __name__ == "__main__":
    main()
