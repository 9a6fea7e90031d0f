"""People without a pointer, with large letters, with a bad network, and with a question about one cell."""

from __future__ import annotations

from browsing import CUT, Pages, Watched, box_of, seen, time_s, wait_until
from cutting import Way
from playwright.sync_api import Page, expect
from stories import FONTS, STYLED, Stories, settled

FOCUSED = "() => document.activeElement.innerText || document.activeElement.getAttribute('aria-label') || ''"

STOP = """() => {
    const one = document.activeElement, box = one.getBoundingClientRect(), style = getComputedStyle(one)
    const x = box.x + box.width / 2, y = box.y + box.height / 2
    const shows = (around) => {
        const of = around.getBoundingClientRect()
        return of.left <= x && x <= of.right && of.top <= y && y <= of.bottom
    }
    const cutting = []
    for (let around = one.parentElement; around; around = around.parentElement)
        if (getComputedStyle(around).overflow !== 'visible') cutting.push(around)
    const named = document.getElementById(one.getAttribute('aria-labelledby') ?? '') ?? one.labels?.[0] ?? one
    return {
        what: one.outerHTML.slice(0, 120),
        name: (one.getAttribute('aria-label') ?? (named.textContent || one.title)).trim(),
        marked: style.outlineStyle !== 'none' || style.boxShadow !== 'none',
        inside: cutting.every(shows) && shows(document.documentElement),
    }
}"""
"""The element with the focus."""

HEIGHT = "one => one.getBoundingClientRect().height"
"""Of a view; of less than the window it is squeezed instead of scrolled."""


def tab_to(page: Page, name: str) -> None:
    """Press Tab until what has the focus is called so."""
    for _ in range(150):
        page.keyboard.press("Tab")
        if page.evaluate(FOCUSED).strip() == name:
            return
    raise AssertionError(f"Tab does not reach '{name}'")


def test_a_run_is_steered_and_a_body_is_moved_without_a_pointer(husky: str, watched: Watched):
    page = watched.open(husky)
    page.keyboard.press("Space")
    wait_until(page, 0.2)
    page.keyboard.press("Space")
    page.get_by_role("button", name="Play").wait_for()
    there = time_s(page)
    page.keyboard.press(".")
    expect(page.get_by_role("timer")).to_contain_text(f"{there + 0.02:.2f} s")
    page.keyboard.press("s")
    page.get_by_role("button", name="Restore the snapshot", exact=False).wait_for()
    tab_to(page, "husky")
    page.keyboard.press("Enter")
    inspector = page.get_by_role("region", name="Selected")
    expect(inspector.get_by_role("heading", name="husky", exact=True)).to_be_visible()
    inspector.get_by_role("textbox", name="x (m)").focus()
    page.keyboard.press("Control+A")
    page.keyboard.type("1.5")
    tab_to(page, "Place")
    page.keyboard.press("Enter")
    expect(inspector.get_by_role("region", name="Pose")).to_contain_text("1.50")
    page.keyboard.press("Escape")
    expect(inspector.get_by_role("button", name="husky", exact=True)).to_be_visible()


def test_each_tab_stop_has_a_name_and_is_marked_in_view(husky: str, watched: Watched):
    page = watched.open(husky)
    page.get_by_role("button", name="Play").wait_for()
    stops = []
    while not stops or stops[-1]["what"] != stops[0]["what"] or len(stops) == 1:
        page.keyboard.press("Tab")
        stops.append(page.evaluate(STOP))
        assert len(stops) < 300, "Tab does not come round"
    own = [stop for stop in stops if not stop["what"].startswith("<body")]  # that is the browser's own bar
    assert len(own) > 20
    assert [stop for stop in own if not (stop["name"] and stop["marked"] and stop["inside"])] == []
    page.evaluate("() => document.activeElement.style.setProperty('outline', 'none')")
    assert not page.evaluate(STOP)["marked"]
    page.get_by_role("link", name="Functions", exact=True).click()
    page.locator(".cm-line").first.click()
    page.keyboard.type("# of mine ")
    page.keyboard.press("Escape")  # closes proposals, if there are any
    page.keyboard.press("Escape")
    page.keyboard.press("Tab")
    expect(page.locator(".cm-content:focus")).to_have_count(0)
    page.keyboard.press("Shift+Tab")
    expect(page.locator(".cm-content:focus")).to_have_count(1)


def test_at_200_percent_nothing_is_lost_sideways(husky: str, watched: Watched):
    page = watched.open(husky, width=720, height=450)
    page.get_by_role("button", name="Play").click()
    wait_until(page, 0.1)
    for view in ("Cockpit", "Functions", "Designer", "Compare"):
        page.get_by_role("link", name=view, exact=True).click()
        shown = page.locator(f"#main .{view.lower()}")
        shown.wait_for()
        seen(page, lambda shown=shown: shown.evaluate(HEIGHT), lambda px: px >= 440)  # type: ignore[misc]
        seen(page, lambda: page.evaluate("() => document.documentElement.scrollWidth <= innerWidth"))
        expect(page.get_by_role("button", name="Pause")).to_be_in_viewport()


def test_no_tool_of_a_panel_is_cut_off_in_a_narrow_page(husky: str, watched: Watched):
    page = watched.open(husky, 1000, 800)
    expect(
        page.get_by_role("region", name="Scene").get_by_role("button", name="Fit", exact=False)
    ).to_be_visible()
    seen(page, lambda: page.locator("#main .panel-head").evaluate_all(CUT), lambda cut: cut == [])


SIDEWAYS = """() => [...document.querySelectorAll("#root, .bar, .rail, .status, .main, .panel-head")]
    .filter(one => one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).overflowX !== "hidden")
    .map(one => `${one.className}: ${one.scrollWidth}`)"""
"""The parts of the page that are wider than their place."""


def test_a_run_is_watched_on_a_phone_in_one_column(husky: str, watched: Watched):
    page = watched.open(husky, 390, 844)
    page.get_by_role("button", name="Play").click()
    wait_until(page, 0.1)
    page.get_by_role("button", name="Pause").click()
    boxes = []
    for panel in ("Scene", "Camera", "From above", "Brain", "Spikes", "Devices and topics", "Selected"):
        one = page.get_by_role("region", name=panel, exact=True)
        boxes.append(box_of(one))
        assert boxes[-1]["width"] > 360
        expect(one.locator("h2")).to_be_in_viewport()
    for view in ("Cockpit", "Functions", "Compare"):
        page.get_by_role("link", name=view, exact=True).click()
        page.locator(f"#main .{view.lower()}").wait_for()
        seen(page, lambda: page.evaluate(SIDEWAYS), lambda wide: wide == [])
        expect(page.get_by_role("link", name=view, exact=True)).to_be_in_viewport()
        expect(page.get_by_role("button", name="Play")).to_be_in_viewport()


SMALL = """() => [...document.querySelectorAll("button, a[href], input, select, summary, [role=tab]")]
    .filter(one => one.checkVisibility({ visibilityProperty: true }))
    .map(one => {
        const { width, height } = one.getBoundingClientRect(), around = getComputedStyle(one, "::before")
        const grown = around.position === "absolute" ? around : { width: "0", height: "0" }
        const size = [Math.max(width, parseFloat(grown.width)), Math.max(height, parseFloat(grown.height))]
        return [one.getAttribute("aria-label") ?? one.textContent, ...size]
    })
    .filter(([, width, height]) => width > 1 && (width < 24 || height < 24))"""
"""The controls that are too small for people whose hands shake, with their sizes in pixels."""


def test_every_control_can_be_hit(husky: str, watched: Watched):
    page = watched.open(husky)
    page.keyboard.press("s")
    page.get_by_role("button", name="Restore the snapshot", exact=False).wait_for()
    expect(page.get_by_role("button", name="Remove left_wheel_neuron")).to_be_visible()
    for view in ("Cockpit", "Functions", "Designer", "Compare"):
        page.get_by_role("link", name=view, exact=True).click()
        page.locator(f"#main .{view.lower()}").wait_for()
        seen(page, lambda: page.evaluate(SMALL), lambda small: small == [])


def test_the_theme_is_that_of_the_system_until_another_is_chosen(husky: str, watched: Watched):
    page = watched.open(husky)
    page.emulate_media(color_scheme="dark")
    page.reload()
    expect(page.locator("html")).to_have_class("theme-dark")
    page.get_by_role("button", name="Switch between light and dark").click()
    page.reload()
    expect(page.locator("html")).to_have_class("theme-light")
    page.emulate_media(color_scheme="null")


def test_the_page_comes_back_when_its_server_does(husky: str, pages: Pages):
    way = Way(husky)
    unwatched = Watched(pages)  # it complains when it is cut
    page = unwatched.open(way.address)
    page.get_by_role("button", name="Play").click()
    wait_until(page, 0.2)
    way.cut()
    expect(page.get_by_text("Reconnecting", exact=False)).to_be_visible()
    expect(page.get_by_role("main")).to_have_css("opacity", "0.6")
    expect(page.get_by_role("button", name="Reset", exact=True)).to_be_disabled()
    cut_at = time_s(page)
    way.mend()
    expect(page.get_by_text("Live on this machine")).to_be_visible()
    expect(page.get_by_role("main")).to_have_css("opacity", "1")
    wait_until(page, cut_at + 0.5)  # the run went on, and the page with it
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()
    unwatched.close()
    way.close()


def test_a_cell_shows_its_membrane_and_a_projection_its_weights(
    husky: str, watched: Watched, stories: Stories
):
    page = watched.open(husky)
    page.evaluate(STYLED, FONTS)
    inspector = page.get_by_role("region", name="Selected")
    inspector.get_by_role("button", name="green blue eye → right wheel neuron").click()
    expect(inspector.get_by_role("region", name="Weights")).to_contain_text("uS")
    expect(inspector.get_by_role("img", name="Histogram of the weights", exact=False)).to_be_visible()
    weights = inspector.get_by_role("region", name="Weights").get_by_role("row")
    before = weights.nth(1).get_by_role("cell").nth(1).inner_text()
    assert float(before) > 0
    inspector.get_by_role("button", name="\N{MULTIPLICATION SIGN} 2", exact=True).click()
    expect(weights.nth(1)).to_contain_text(f"{2 * float(before):g}")
    expect(weights.nth(2)).to_contain_text(before)
    page.mouse.move(0, 0)
    stories.compare("live", settled(page, {"weights": inspector}))
    inspector.get_by_label("Weight of all synapses").fill(before)
    inspector.get_by_role("button", name="Set", exact=True).click()
    expect(weights.nth(1)).to_contain_text(before)
    expect(page.get_by_role("list", name="Events")).to_contain_text(f"weights of [4] to [7] = {before}")
    page.keyboard.press("Escape")
    cell = page.get_by_role("region", name="Brain", exact=True).get_by_role(
        "button", name="Neuron 4 of circuit", exact=False
    )
    cell.first.click()
    expect(inspector.get_by_role("region", name="Membrane")).to_contain_text("mV")
