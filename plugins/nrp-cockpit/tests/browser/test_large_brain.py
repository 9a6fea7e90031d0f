"""Brains of many cells: their groups as bands and boxes, and views of some of the cells."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from browsing import Cockpits, Kept, Watched, box_of, seen, wait_until
from large_brain import large_brain
from playwright.sync_api import Locator, Page, expect

INKED = """canvas => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const pixels = new Uint32Array(data.buffer);
    let sum = 0;
    for (let at = 0; at < pixels.length; at++) sum = (sum * 31 + pixels[at]) >>> 0;
    return sum;
}"""
"""Gives a number that differs if the picture does."""


@pytest.fixture(scope="session")
def ring(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An experiment with 2000 cells in a ring, of which two eighths are groups."""
    return large_brain(tmp_path_factory.mktemp("ring"))


@pytest.fixture
def page(ring: Path, kept: Kept, watched: Watched) -> Page:
    """A cockpit after a second of the ring."""
    page = watched.open(kept.open(str(ring)))
    expect(page.get_by_role("img", name="Spikes of ring, kicks")).to_be_visible()
    go_on(page)
    return page


def go_on(page: Page) -> None:
    """Run for the first second."""
    page.get_by_role("slider", name="Simulated time").press("PageUp")
    expect(page.get_by_role("timer")).to_contain_text("1.00 s")
    page.get_by_role("button", name="Play").wait_for()


def plot_of(page: Page) -> Locator:
    return page.get_by_role("img", name="Spikes of ring, kicks")


def choose(page: Page, item: str) -> None:
    """Choose an item of the menu of the cells."""
    page.get_by_role("button", name="Cells in the plot").click()
    page.get_by_role("menuitem", name=item).click()


def selected(page: Page) -> Locator:
    return page.get_by_role("region", name="Selected").locator(".inspector-title")


@pytest.mark.heavy
def test_a_click_on_a_band_selects_its_group(page: Page):
    plot = plot_of(page)
    box = box_of(plot)
    for share, name, cells in ((0.1, "east", 250), (0.33, "west", 250), (0.52, "marked", 20)):
        plot.click(position={"x": 20, "y": 16 + share * (box["height"] - 34)})
        expect(selected(page)).to_contain_text(name)
        expect(selected(page)).to_contain_text(f"{cells} cells")
    expect(page.get_by_role("navigation", name="Contents of the run")).to_have_count(0)
    page.keyboard.press("Escape")
    outline = page.get_by_role("navigation", name="Contents of the run")
    for group in ("east", "west", "marked"):
        expect(outline.get_by_role("button", name=group, exact=True)).to_be_visible()
    expect(outline.get_by_role("button", name="kicks", exact=True)).to_have_count(1)  # the population alone


@pytest.mark.heavy
def test_the_wheel_beside_the_cells_zooms_to_one_and_a_double_click_shows_all(page: Page):
    plot = plot_of(page)
    before = plot.evaluate(INKED)
    plot.hover(position={"x": 20, "y": 100})
    for _ in range(12):
        page.mouse.wheel(0, -600)
    seen(page, lambda: plot.evaluate(INKED), lambda picture: picture != before)
    plot.click(position={"x": 300, "y": 100})
    expect(selected(page)).to_contain_text(re.compile(r"^ring \d+"))
    one = int(selected(page).inner_text().split()[1])
    box = box_of(plot)
    page.mouse.move(box["x"] + 300, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 301, box["y"] + 50, steps=5)
    page.mouse.up()
    plot.click(position={"x": 300, "y": 100})
    expect(selected(page)).not_to_contain_text(f"ring {one}\n")
    assert 0 < int(selected(page).inner_text().split()[1]) - one < 8
    expect(page.get_by_role("button", name="Resume the spikes")).to_have_count(0)  # time was not dragged
    plot.dblclick()
    page.keyboard.press("Escape")
    page.mouse.move(0, 0)
    seen(page, lambda: plot.evaluate(INKED), lambda picture: picture == before)


def test_silent_cells_can_be_hidden(page: Page):
    spikes = page.get_by_role("region", name="Spikes")
    choose(page, "Active cells first")
    expect(spikes).to_contain_text(re.compile(r"in 1 s, of [\d,]+ cells in sight"))
    shown = int(spikes.inner_text().split(", of ")[1].split(" cells")[0].replace(",", ""))
    assert 0 < shown <= 2004
    choose(page, "By number")
    expect(spikes).not_to_contain_text("in sight")


def test_rates_are_shown_as_colours_of_groups_or_of_cells(page: Page):
    plot, spikes = plot_of(page), page.get_by_role("region", name="Spikes")
    pictures = [plot.evaluate(INKED)]

    def is_another() -> None:
        pictures.append(seen(page, lambda: plot.evaluate(INKED), lambda picture: picture not in pictures))

    spikes.get_by_role("radio", name="Heat").click()
    is_another()
    choose(page, "Heat of cells")
    is_another()
    spikes.get_by_role("radio", name="Rates").click()
    is_another()


LEARNS = """\
import nrp_core.pynn as sim

sim.setup(timestep=1.0)
pre = sim.Population(20, sim.SpikeSourcePoisson(rate=40.0), label="pre")
post = sim.Population(20, sim.IF_curr_exp(), label="post")
stdp = sim.STDPMechanism(
    timing_dependence=sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=0.02, A_minus=0.01),
    weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=4.0), weight=2.0, delay=1.0)
sim.Projection(pre, post, sim.AllToAllConnector(), stdp, label="learned")
half = post[:10]
"""


@pytest.fixture(scope="session")
def learning(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An experiment with a projection that learns."""
    file = large_brain(tmp_path_factory.mktemp("learning"))
    (file.parent / "brain.py").write_text(LEARNS)
    return file


@pytest.mark.heavy
def test_weights_are_plotted_over_time_and_compared_at_two_moments(
    learning: Path, kept: Kept, watched: Watched
):
    page = watched.open(kept.open(str(learning)))
    inspector = page.get_by_role("region", name="Selected")
    page.get_by_role("button", name="Projection learned: excites, 400 synapses").press("Enter")
    pin = inspector.get_by_role("button", name="Pin", exact=True)
    pin.click()
    inspector.get_by_role("button", name="Over time").click()
    inspector.get_by_role("button", name="Synapse", exact=True).click()
    page.get_by_role("searchbox", name="Search the synapses").fill("0 to 0")
    page.keyboard.press("Enter")
    expect(page.get_by_role("img", name="Curves of mean, 5 %, 95 %")).to_be_visible()
    go_on(page)
    mean = page.get_by_role("region", name="/brain/projections/learned/weights").get_by_role("listitem").first
    expect(mean).to_contain_text(re.compile(r"mean\s*3\.\d"))
    one = page.get_by_role("region", name="/brain/projections/learned/synapses").get_by_role("listitem")
    expect(one).to_contain_text(re.compile(r"0 to 0\s*[234]\.\d"))
    rows = inspector.get_by_role("region", name="Weights").get_by_role("row")
    expect(rows.nth(1)).to_contain_text(re.compile(r"now\s*[23]\.?\d*"))
    expect(rows.nth(2)).to_contain_text(re.compile(r"^\s*0 s\s*2\s*2\s*2"))
    pin.click()
    expect(rows.nth(3)).to_contain_text("1 s")
    outlines = inspector.get_by_role("img", name="Histogram of the weights from 1 to 4").locator("polyline")
    expect(outlines).to_have_count(3)
    inspector.get_by_role("button", name="Unpin").first.click()
    expect(rows).to_have_count(3)


def test_a_group_shows_its_rate_membranes_and_synapses(learning: Path, kept: Kept, watched: Watched):
    page = watched.open(kept.open(str(learning)))
    page.get_by_role("button", name="Group half of post: 10 cells").click()
    inspector = page.get_by_role("region", name="Selected")
    expect(inspector.get_by_role("region", name="Synapses to it")).to_contain_text(
        re.compile(r"pre\s*200\s*2")
    )
    go_on(page)
    rate = inspector.get_by_role("region", name="Rate")
    expect(rate).to_contain_text(re.compile(r"up to \d{3,} Hz"))
    expect(inspector.get_by_role("region", name="Membranes").get_by_role("listitem")).to_have_count(4)


def test_cells_are_shown_in_space_and_selected_there(page: Page):
    brain = page.get_by_role("region", name="Brain", exact=True)
    brain.get_by_role("radio", name="3D").click()
    cloud = brain.get_by_role("application", name="The cells of ring in space")
    expect(cloud).to_be_visible()
    before = seen(page, cloud.screenshot, lambda picture: len(picture) > 2000)
    cloud.focus()
    page.keyboard.press("ArrowLeft")
    turned = seen(page, cloud.screenshot, lambda picture: picture != before)
    page.get_by_role("button", name="Step", exact=True).click()
    seen(page, cloud.screenshot, lambda picture: picture != turned)
    box = box_of(cloud)
    for x in range(8, int(box["width"] / 2), 12):
        cloud.click(position={"x": x, "y": box["height"] / 2})
        if selected(page).count():
            break
    expect(selected(page)).to_contain_text(re.compile(r"^ring \d+"))
    brain.get_by_role("radio", name="Graph").click()
    expect(brain.get_by_role("button", name="Group east of ring", exact=False)).to_be_visible()


CELLS, PACKETS, SPIKES_HZ = 140_000, 40, 60_000
FRAMES_HZ, FRAME_MS, WATCHED_MS = 30.0, 8.0, 4000.0
FRAMES = """wall_ms => new Promise((done) => {
    const began = performance.now();
    let frames = 0;
    const next = (now) => {
        frames++;
        if (now - began < wall_ms) requestAnimationFrame(next);
        else done(frames);
    };
    requestAnimationFrame(next);
})"""


def frames(page: Page) -> tuple[float, float]:
    """Return the frames a second, and the CPU time of the page's main thread for each, ms."""
    devtools = page.context.new_cdp_session(page)
    devtools.send("Performance.enable", {"timeDomain": "threadTicks"})

    def spent_ms() -> float:
        metrics = devtools.send("Performance.getMetrics")["metrics"]
        return 1000 * float(next(each["value"] for each in metrics if each["name"] == "ThreadTime"))

    before_ms = spent_ms()
    count = int(page.evaluate(FRAMES, WATCHED_MS))
    return count * 1000 / WATCHED_MS, (spent_ms() - before_ms) / count


@pytest.mark.heavy
def test_a_brain_of_140_000_cells_is_drawn_30_times_a_second(
    tmp_path: Path, cockpits: Cockpits, watched: Watched
):
    file = large_brain(tmp_path, CELLS, PACKETS)
    page = watched.open(cockpits.open(str(file), "-s", "duration=600 s"), width=1280, height=720)
    page.get_by_role("button", name="Play").click()
    wait_until(page, 5.0)
    spikes = page.get_by_role("region", name="Spikes")
    count = int(spikes.locator(".panel-sub").inner_text().split()[0])
    assert count > SPIKES_HZ
    spikes.get_by_role("button", name="Full size").click()
    measured = {}
    for kind in ("Spikes", "Heat", "Rates"):
        spikes.get_by_role("radio", name=kind).click()
        measured[kind] = frames(page)
    page.keyboard.press("Escape")
    brain = page.get_by_role("region", name="Brain", exact=True)
    brain.get_by_role("radio", name="3D").click()
    brain.get_by_role("button", name="Full size").click()
    expect(brain.get_by_role("application")).to_be_visible()
    measured["3D"] = frames(page)
    for kind, (frames_hz, frame_ms) in measured.items():
        print(f"{kind}: {frames_hz:.0f} frames a second, {frame_ms:.1f} ms of CPU each", flush=True)
    assert all(frame_ms < FRAME_MS for _, frame_ms in measured.values()), measured
    assert all(measured[kind][0] >= FRAMES_HZ for kind in ("Spikes", "Heat", "Rates")), (
        measured
    )  # 3D needs a GPU
