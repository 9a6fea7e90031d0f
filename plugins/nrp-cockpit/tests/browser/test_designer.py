"""An experiment is drawn in the designer, by pointer and by typing into fields, and runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from browsing import HUSKY, Cockpits, Watched
from nrp_bibi import read_bibi
from playwright.sync_api import Locator, Page, expect

from nrp_core.experiment.reading.find import find_file

SLOW_MS = 60_000
MOST_ACTIONS = 60
PAPER = find_file("braitenberg_husky").parent
FAST = ("-s", "duration=16 s", *HUSKY)
"""Long enough for both screens."""


class Hand:
    """Somebody at the page of a designer, who counts clicks, drags and filled fields."""

    def __init__(self, page: Page) -> None:
        self.page, self.actions = page, 0

    def click(self, role: str, name: str) -> None:
        self.actions += 1
        self.page.get_by_role(role, name=name, exact=True).click()  # type: ignore[arg-type]

    def fill(self, label: str, text: str) -> None:
        self.actions += 1
        self.page.get_by_label(label, exact=True).first.fill(text)

    def write(self, text: str) -> None:
        """Write the expression of what is shown."""
        self.actions += 1
        self.page.get_by_role("region", name="Form").get_by_role("textbox", name=" as Python").fill(text)

    def choose(self, label: str, choice: str) -> None:
        self.actions += 1
        self.page.get_by_label(label, exact=True).select_option(choice)

    def wire(self, source: str, target: str) -> None:
        """Drag from the end of a wire onto a box."""
        self.actions += 1
        self.drag(self.end(source), self.box(target))

    def drag(self, source: Locator, target: Locator) -> None:
        source.hover()
        self.page.mouse.down()
        where = target.bounding_box()
        assert where is not None
        self.page.mouse.move(where["x"] + 40, where["y"] + 12, steps=6)
        self.page.mouse.up()

    def end(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=f"Wire of {name}", exact=True)

    def box(self, name: str) -> Locator:
        return self.page.get_by_role("group", name=name)

    def wired(self, source: str, target: str) -> None:
        """Drag a wire that fits: the form of what it made is there when its name has the focus."""
        self.wire(source, target)
        expect(self.page.get_by_label("name", exact=True).first).to_be_focused()

    def named(self, name: str) -> None:
        """Name what was just made: its name has the focus."""
        expect(self.page.get_by_label("name", exact=True).first).to_be_focused()
        self.fill("name", name)

    def variable(self, function: str, name: str, text: str) -> None:
        self.click("button", f"Add a variable to {function}")
        self.named(name)
        self.write(text)


def shown(page: Page) -> None:
    page.get_by_role("region", name="Drawing").wait_for(timeout=SLOW_MS)


@pytest.fixture
def drawn(cockpits: Cockpits, watched: Watched, tmp_path: Path) -> tuple[Hand, Path]:
    """An empty canvas beside the Husky, and the file that it is for."""
    file = tmp_path / "drawn.bibi"
    page = watched.open(cockpits.design(str(file), "-e", "braitenberg_husky", *FAST), 1280, 720)
    shown(page)
    return Hand(page), file


def draw_wheels(hand: Hand) -> None:
    hand.click("button", "Neurons → robot")
    hand.named("linear_twist")
    for name in ("left_wheel_neuron", "right_wheel_neuron"):
        hand.wired("actors", "function linear_twist")
        hand.named(name)
    both = "left_wheel_neuron.voltage, right_wheel_neuron.voltage"
    turn = "right_wheel_neuron.voltage - left_wheel_neuron.voltage"
    hand.variable("linear_twist", "linear", f"geometry_msgs.msg.Vector3(20 * min({both}), 0, 0)")
    hand.variable("linear_twist", "angular", f"geometry_msgs.msg.Vector3(0, 0, 100 * ({turn}))")
    hand.wired("/husky/cmd_vel", "function linear_twist")
    hand.write("geometry_msgs.msg.Twist(linear=linear, angular=angular)")


def draw_eyes(hand: Hand) -> None:
    hand.click("button", "Robot → neurons")
    hand.named("eye_sensor_transmit")
    hand.wired("/husky/camera", "function eye_sensor_transmit")
    hand.variable("eye_sensor_transmit", "image_results", "nrp.tf_lib.detect_red(camera.value)")
    for name, cells, share in (
        ("red_left_eye", "0, 2", "leftred"),
        ("red_right_eye", "1, 3", "rightred"),
        ("green_blue_eye", "4", "greenblue"),
    ):
        hand.wired("sensors", "function eye_sensor_transmit")
        hand.named(name)
        if "," in cells:
            hand.choose("neurons", "List")
        hand.fill("element" if "," in cells else "index", cells)
        hand.write(f"1000.0 * image_results.{share}")


def test_the_experiment_of_the_paper_is_drawn_from_nothing_and_passes(drawn: tuple[Hand, Path]):
    hand, file = drawn
    draw_wheels(hand)
    draw_eyes(hand)
    hand.click("button", "Save")
    expect(hand.page.get_by_text(f"Saved {file}.")).to_be_visible(timeout=SLOW_MS)
    assert read_bibi(file).transfer_function == (
        *read_bibi(PAPER / "listing1.bibi").transfer_function,
        *read_bibi(PAPER / "listing2.bibi").transfer_function,
    )
    hand.click("button", "Run")
    page = hand.page
    expect(page.get_by_role("link", name="Cockpit")).to_have_attribute(
        "aria-current", "page", timeout=SLOW_MS
    )
    expect(page.get_by_role("timer")).to_contain_text("16.00 s", timeout=4 * SLOW_MS)
    criteria = page.get_by_role("list", name="Criteria")
    for criterion in ("turns_on_the_spot", "reaches_left", "reaches_right", "turns_on_the_spot_again"):
        expect(criteria).to_contain_text(f"{criterion}, met", timeout=SLOW_MS)
    assert hand.actions < MOST_ACTIONS, hand.actions


def test_a_wire_that_does_not_fit_says_why_and_each_step_goes_back(drawn: tuple[Hand, Path]):
    hand, _ = drawn
    page = hand.page
    hand.click("button", "Monitor")
    hand.named("wheels")
    hand.wire("/husky/odom", "function wheels")
    expect(page.get_by_text("a monitor shows a device on neurons; /husky/odom is a topic")).to_be_visible()
    hand.fill("name", "1st")
    page.keyboard.press("Tab")
    expect(page.get_by_role("alert")).to_contain_text("'name' cannot be '1st'")
    page.keyboard.press("Escape")
    hand.click("button", "Undo")
    expect(hand.box("function monitor")).to_be_visible()
    hand.click("button", "Undo")
    expect(hand.box("function monitor")).to_have_count(0)
    hand.click("button", "Redo")
    hand.click("button", "Redo")
    expect(hand.box("function wheels")).to_be_visible()


def test_xml_python_and_drawing_are_in_step_both_ways(drawn: tuple[Hand, Path], watched: Watched):
    hand, file = drawn
    page = hand.page
    draw_eyes(hand)
    xml = page.get_by_role("textbox", name="XML")
    expect(xml).to_contain_text('factor="1000.0"')
    page.locator(".cm-line", has_text='topic="/husky/camera"').dblclick()
    page.keyboard.press("Control+a")
    page.keyboard.insert_text('<bibi><transferFunction xsi:type="Neuron2Robot" nam="w"/></bibi>')
    texts = page.get_by_role("region", name="Texts")
    expect(texts.get_by_role("status")).to_contain_text("has no attribute 'nam'; did you mean 'name'?")
    expect(hand.box("function eye_sensor_transmit")).to_be_visible()
    page.keyboard.press("Control+a")
    page.keyboard.insert_text('<bibi><transferFunction xsi:type="Neuron2Robot" name="w"/></bibi>')
    expect(hand.box("function w")).to_be_visible()
    hand.click("radio", "Python")
    python = page.get_by_role("textbox", name="Python")
    expect(python).to_contain_text("def w(t):")
    python.focus()
    page.keyboard.press("Control+a")
    page.keyboard.insert_text(
        "@nrp.Neuron2Robot(Topic('/a', std_msgs.msg.Float64))\ndef made(t):\n    return 2.0 * t"
    )
    expect(hand.box("function made")).to_be_visible()
    hand.click("button", "Save")
    expect(page.get_by_text(f"Saved {file}.")).to_be_visible()
    assert "made" in file.read_text()
    page.reload()
    shown(page)
    expect(hand.box("function made")).to_be_visible()


def test_python_that_is_blocks_opens_as_boxes_in_the_cockpit_too(cockpits: Cockpits, watched: Watched):
    page = watched.open(cockpits.open("braitenberg_husky", *HUSKY), 1280, 720)
    page.get_by_role("link", name="Designer").click()
    shown(page)
    expect(page.get_by_role("group", name="function linear_twist")).to_be_visible()
    page.keyboard.press("Control+z")
    page.get_by_role("button", name="Files").click()
    expect(page.get_by_role("menuitem", name="listing2.py")).to_be_visible()
