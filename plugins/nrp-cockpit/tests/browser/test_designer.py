"""An experiment is drawn in the designer, by pointer and by typing into fields, and runs."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from struct import unpack_from

import pytest
from browsing import HUSKY, PATIENCE_MS, Cockpits, Watched, box_of, running, seen, wait_until
from nrp_bibi import bibi_text, read_bibi
from nrp_bibi.model.functions import Neuron2Robot, PythonTransferFunction
from nrp_bibi.model.selectors import Index
from nrp_cockpit.designer.brain.model import Brain
from nrp_cockpit.designer.brain.script import script_of
from playwright.sync_api import Browser, Locator, Page, WebSocketRoute, expect
from visitors import cockpit, visit

from nrp_core.experiment.making.maker import network_from
from nrp_core.experiment.reading.find import find_file

MOST_ACTIONS = 60
MOST_TABS = 120
LOWER_PX = 64
PAPER = find_file("braitenberg_husky").parent
OPAQUE = "@nrp.Robot2Neuron()\ndef waits(t):\n    while t > 1:\n        t -= 1"
FAST = ("-s", "events.left_red.at=1 s", "-s", "duration=10 s", *HUSKY)
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
        where = box_of(target)
        self.page.mouse.move(where["x"] + 40, where["y"] + 12, steps=6)
        self.page.mouse.up()

    def move(self, name: str, by: tuple[int, int]) -> None:
        """Drag a box by its head."""
        where = box_of(self.box(name))
        x, y = where["x"] + 50, where["y"] + 12
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + by[0], y + by[1], steps=6)
        self.page.mouse.up()

    def tab_to(self, role: str, name: str) -> None:
        """Press Tab until something has the focus."""
        wanted = self.page.get_by_role(role, name=name, exact=True).first  # type: ignore[arg-type]
        wanted.wait_for()
        for _ in range(MOST_TABS):
            if wanted.evaluate("one => one === document.activeElement"):
                return
            self.page.keyboard.press("Tab")
        raise AssertionError(f"no Tab leads to the {role} '{name}'")

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
    page.get_by_role("region", name="Drawing").wait_for()


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a designer beside the Husky, which all tests share; each draws into files of its own."""
    file = tmp_path_factory.mktemp("studio") / "first.bibi"
    with running() as cockpits:
        yield cockpits.design(str(file), "-e", "braitenberg_husky", *FAST)


@pytest.fixture
def drawn(studio: str, watched: Watched, tmp_path: Path) -> tuple[Hand, Path]:
    """An empty canvas, and the file that it is for."""
    file = tmp_path / "drawn.bibi"
    with visit(studio) as visitor:
        visitor.call("designer/open", file=str(PAPER / "brain.py"))  # in place of one that was drawn
        visitor.call("designer/open", file=str(file))
    page = watched.open(studio, 1280, 720)
    shown(page)
    expect(page.get_by_role("button", name="Files")).to_contain_text(file.name)
    return Hand(page), file


@pytest.fixture
def alone(cockpits: Cockpits, watched: Watched, tmp_path: Path) -> tuple[Hand, Path]:
    """An empty canvas in a designer of its own, which runs fast: what others drew there would run, too."""
    file = tmp_path / "drawn.bibi"
    address = cockpits.design(str(file), "-e", "braitenberg_husky", *FAST)
    with visit(address) as visitor:
        visitor.call("pace", factor=None)
    page = watched.open(address, 1280, 720)
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


@pytest.mark.heavy
def test_xml_python_and_drawing_are_in_step_both_ways(drawn: tuple[Hand, Path], watched: Watched):
    hand, file = drawn
    page = hand.page
    draw_eyes(hand)
    form = page.get_by_role("region", name="Form")
    hand.write("1000.0 * image_resul.greenblue")
    page.keyboard.press("Tab")
    expect(form.get_by_role("alert")).to_contain_text("did you mean 'image_results'?")
    expect(page.get_by_role("listbox")).to_have_count(0)  # the names that it proposed would hide the reason
    heading = box_of(form.get_by_role("heading", name="rate"))
    assert heading["y"] + heading["height"] <= box_of(form.get_by_role("textbox", name="rate as Python"))["y"]
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


@pytest.mark.heavy
def test_python_that_is_blocks_opens_as_boxes_in_the_cockpit_too(husky: str, watched: Watched):
    page = watched.open(husky, 1280, 720)
    page.get_by_role("link", name="Designer").click()
    shown(page)
    expect(page.get_by_role("group", name="function linear_twist")).to_be_visible()
    other = page.get_by_role("group", name="other eye_sensor_transmit")
    expect(other).to_contain_text("listing2.py")
    expect(page.locator(".react-flow__edge")).to_have_count(3 + 4)  # the loop through both files
    other.get_by_role("button", name="device red_left_eye", exact=False).click()
    expect(page.get_by_role("group", name="function eye_sensor_transmit")).to_be_visible()
    expect(page.get_by_role("group", name="other linear_twist")).to_contain_text("listing1.py")
    page.keyboard.press("Control+z")
    page.get_by_role("button", name="Files").click()
    expect(page.get_by_role("menuitem", name="listing2.py")).to_be_visible()


@pytest.mark.heavy
def test_python_is_wired_and_undo_works_wherever_the_focus_is(watched: Watched):
    with cockpit(experiment="slalom_pioneer") as opened:
        page = watched.open(opened.address, 1280, 720)
        page.get_by_role("link", name="Designer").click()
        box = page.get_by_role("group", name="python feel, drive")
        box.get_by_role("button", name="topic drive: return Twist").click()
        expect(page.get_by_role("region", name="Form")).to_contain_text("def drive")
        expect(page.locator(".react-flow__edge")).to_have_count(7)
        page.get_by_role("button", name="Neurons \N{RIGHTWARDS ARROW} robot").click()
        made = page.get_by_role("group", name="function to_robot")
        expect(made).to_be_visible()
        page.evaluate("() => document.activeElement.blur()")
        page.keyboard.press("Control+z")
        expect(made).to_have_count(0)


@pytest.mark.heavy
def test_wires_show_the_latest_values_of_the_run(watched: Watched) -> None:
    with cockpit(experiment="slalom_pioneer") as opened:
        page = watched.open(opened.address, 1280, 720)
        page.get_by_role("link", name="Designer").click()
        read = page.locator(".react-flow__edge[aria-label*='reads neurons'] .react-flow__edge-text")
        expect(read).to_have_text(["0 Hz"] * 2)
        page.get_by_role("button", name="Play").click()
        wait_until(page, 1.0)
        page.get_by_role("button", name="Pause").click()
        page.get_by_role("button", name="Play").wait_for()
        topics = [f"/brain/devices/drive/{side}/rate" for side in ("left", "right")]
        with opened.visit() as visitor:
            visitor.subscribe(*topics)
            visitor.until(lambda: all(visitor.heard[topic] for topic in topics))
            rates_hz = [unpack_from("<d", visitor.heard[topic][-1].payload, 4)[0] for topic in topics]
        assert all(rates_hz)
        shown_hz = seen(
            page,
            lambda: [float(text.removesuffix(" Hz")) for text in read.all_text_contents()],
            lambda shown: sorted(shown) == pytest.approx(sorted(rates_hz), rel=5e-3),
        )
        assert len(shown_hz) == 2
        sent = page.locator(".react-flow__edge[aria-label*='cmd_vel'] .react-flow__edge-text")
        expect(sent).to_have_text(re.compile(r"^vx \d\.\d+ωz (-?\d\.\d+|0)$"))


def test_a_shipped_model_that_is_typed_in_is_unchanged_and_mistakes_have_a_badge(
    drawn: tuple[Hand, Path], studio: str, tmp_path: Path
):
    hand, _ = drawn
    page = hand.page
    file = tmp_path / "listing2.bibi"
    file.write_text((PAPER / "listing2.bibi").read_text())
    with visit(studio) as visitor:
        visitor.call("designer/open", file=str(file))
    box = hand.box("function eye_sensor_transmit")
    expect(box).to_be_visible()
    text = page.get_by_role("textbox", name="XML")
    rows = box.get_by_role("button").count()
    xml = bibi_text(read_bibi(file))
    retype(text, xml)
    expect(page.get_by_role("region", name="Texts").get_by_role("status")).to_have_text("up to date")
    expect(page.get_by_role("button", name="Undo")).to_be_disabled()
    expect(box.get_by_role("button")).to_have_count(rows)
    assert bibi_text(read_bibi(file)) == xml
    retype(text, xml.replace(' population="sensors" index="4"', ' index="4"'))
    expect(box.get_by_title("population")).to_have_text("1")
    expect(box.locator(".box-row[data-bad]")).to_contain_text("green_blue_eye")


def test_python_that_blocks_cannot_say_is_one_box_that_opens_in_the_editor(drawn: tuple[Hand, Path]):
    hand, file = drawn
    hand.click("button", "Python")
    code = hand.page.get_by_role("region", name="Form").get_by_role("textbox", name="value")
    retype(code, OPAQUE)
    hand.page.keyboard.press("Control+Enter")
    expect(hand.box("python waits")).to_be_visible()
    hand.click("button", "Convert to blocks")
    expect(
        hand.page.get_by_text("this Python function cannot be expressed as blocks; it is unchanged")
    ).to_be_visible()
    hand.click("button", "Save")
    expect(hand.page.get_by_text(f"Saved {file}.")).to_be_visible()
    (function,) = read_bibi(file).transfer_function
    assert isinstance(function, PythonTransferFunction)
    assert function.code == OPAQUE


def retype(text: Locator, new: str) -> None:
    text.focus()
    text.page.keyboard.press("Control+a")
    text.page.keyboard.insert_text(new)


@pytest.mark.heavy
def test_functions_are_wired_by_keyboard_alone(drawn: tuple[Hand, Path]):
    hand, file = drawn
    keyboard = hand.page.keyboard
    hand.tab_to("button", "Neurons → robot")
    keyboard.press("Enter")
    hand.named("wheels")
    keyboard.press("Tab")
    for search, made in (("actors", "device actors_0"), ("cmd", "topic return")):
        hand.tab_to("button", "wheels neurons → robot")
        keyboard.press("Enter")
        hand.tab_to("button", "Connect to")
        keyboard.press("Enter")
        expect(hand.page.get_by_role("searchbox", name="Search the valid ends")).to_be_focused()
        keyboard.insert_text(search)
        keyboard.press("Enter")
        expect(hand.page.get_by_role("button", name=made)).to_be_visible()
    keyboard.press("Control+s")
    expect(hand.page.get_by_text(f"Saved {file}.")).to_be_visible()
    (function,) = read_bibi(file).transfer_function
    assert isinstance(function, Neuron2Robot)
    assert [device.neurons for device in function.device] == [Index(population="actors", index=0)]
    assert function.return_value is not None
    assert function.return_value.topic == "/husky/cmd_vel"


def test_text_typed_before_the_server_answers_is_kept(studio: str, browser: Browser, tmp_path: Path):
    with visit(studio) as visitor:
        visitor.call("designer/open", file=str(tmp_path / "drawn.bibi"))
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    late: list[str | bytes] = []
    is_slow = False

    def between(page_side: WebSocketRoute) -> None:
        server = page_side.connect_to_server()
        server.on_message(lambda message: late.append(message) if is_slow else page_side.send(message))
        links.append(page_side)

    links: list[WebSocketRoute] = []
    context.route_web_socket(re.compile("/ws"), between)
    page = context.new_page()
    page.goto(studio)
    shown(page)
    hand = Hand(page)
    hand.click("button", "Monitor")
    hand.named("first")
    is_slow = True
    page.keyboard.press("Tab")  # asks the server
    page.keyboard.press("Shift+Tab")
    page.keyboard.type("second")
    seen(page, lambda: late)
    is_slow = False
    for message in late:
        links[-1].send(message)
    name = page.get_by_label("name", exact=True).first
    expect(hand.box("function first")).to_be_visible()
    expect(name).to_be_focused()
    expect(name).to_have_value("second")
    page.keyboard.press("Enter")
    expect(hand.box("function second")).to_be_visible()
    name.fill("1st")
    page.keyboard.press("Enter")
    expect(page.get_by_role("alert")).to_be_visible()
    expect(name).to_have_value("1st")
    page.keyboard.press("Escape")
    expect(name).to_have_value("second")
    expect(page.get_by_role("alert")).to_have_count(0)
    context.close()


def test_boxes_are_dragged_by_mouse_stay_there_and_go_back(drawn: tuple[Hand, Path]):
    hand, file = drawn
    hand.click("button", "Robot → neurons")
    hand.named("eyes")
    hand.page.keyboard.press("Tab")
    box = hand.box("function eyes")
    hand.move("function eyes", (60, 80))
    expect(hand.page.get_by_role("button", name="Undo")).to_be_enabled()
    hand.click("button", "Save")
    expect(hand.page.get_by_text(f"Saved {file}.")).to_be_visible()
    (where,) = json.loads(file.with_suffix(".layout.json").read_text())["boxes"].values()
    hand.page.reload()
    shown(hand.page)
    expect(box).to_be_visible()
    assert where[1] > LOWER_PX, "it was put lower than the first row of the columns"
    hand.click("button", "Arrange")
    hand.click("button", "Save")
    seen(hand.page, lambda: not file.with_suffix(".layout.json").exists())


def test_a_brain_is_drawn_by_pointer_and_its_populations_are_there_for_functions(
    drawn: tuple[Hand, Path], studio: str, tmp_path: Path
):
    hand, _ = drawn
    page = hand.page
    hand.click("radio", "Brain")
    expect(hand.box("neurons circuit")).to_be_visible()
    expect(page.get_by_text("brain.py was written by hand and cannot be edited here.")).to_be_visible()
    expect(page.get_by_role("button", name="Save", exact=True)).to_be_disabled()
    (tmp_path / "mine.py").write_text(script_of(Brain()))
    with visit(studio) as visitor:
        visitor.call("designer/open", file=str(tmp_path / "mine.py"))
    for name, cells in (("eyes", "4"), ("wheels", "2")):
        hand.click("button", "Population")
        hand.named(name)
        hand.fill("cells", cells)
        page.keyboard.press("Tab")
        expect(hand.box(f"neurons {name}")).to_contain_text(f"{cells} cells")
    hand.wire("eyes", "neurons wheels")
    expect(page.get_by_label("name", exact=True)).to_have_value("eyes to wheels")
    hand.fill("weight", "-3 uS")
    page.keyboard.press("Tab")
    expect(page.get_by_role("alert")).to_contain_text(
        "'weight' cannot be '-3 uS'; it must be a finite number"
    )
    hand.fill("weight", "0.25")
    page.keyboard.press("Tab")
    expect(page.get_by_role("textbox", name="Python")).to_contain_text("sim.StaticSynapse(weight=0.25)")
    hand.click("button", "Save")
    expect(page.get_by_text(f"Saved {tmp_path / 'mine.py'}.")).to_be_visible()
    network = network_from(tmp_path / "mine.py", seed=1)
    assert {name: one.size for name, one in network.populations.items()} == {"eyes": 4, "wheels": 2}
    (projection,) = network.projections
    assert (projection.pre, projection.post, projection.size) == ("eyes", "wheels", 8)
    assert set(projection.weight) == {0.25}
    hand.click("radio", "Functions")
    expect(hand.box("population wheels")).to_be_visible()
    expect(hand.box("population sensors")).to_have_count(0)


@pytest.mark.heavy
def test_cells_of_a_brain_that_a_person_wrote_are_silenced_by_keyboard_and_the_robot_stands(watched: Watched):
    with cockpit() as here:
        page = watched.open(here.address, 1280, 720)
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        page.get_by_role("link", name="Designer", exact=True).click()
        hand = Hand(page)
        hand.click("radio", "Brain")
        hand.tab_to("button", "Add intervention")
        page.keyboard.press("Enter")
        expect(page.get_by_role("heading", name="silence circuit")).to_be_visible()
        expect(page.get_by_label("kind")).to_be_focused()
        hand.choose("kind", "Activate")
        for label, text in (("rate", "50"), ("weight", "0.00015"), ("duration", "200"), ("at", "300")):
            hand.fill(label, text)
            page.keyboard.press("Enter")
        hand.click("radio", "YAML")
        yaml = page.get_by_role("region", name="Texts").locator("pre")
        drives = "{activate: {cells: circuit, rate: 50 Hz, weight: 0.00015, duration: 200 ms}, at: 300 ms}"
        expect(yaml).to_contain_text(f"    - {drives}")
        hand.choose("kind", "Silence")
        hand.fill("at", "")
        hand.tab_to("combobox", "cells")
        page.keyboard.press("Control+A")
        page.keyboard.type("circit")
        page.keyboard.press("Enter")
        wrong = "the brain has no population 'circit'; did you mean 'circuit'?"
        expect(page.get_by_role("region", name="Form").get_by_text(wrong)).to_be_visible()
        hand.click("button", "Run")
        expect(page.get_by_text(f"The model cannot run yet: {wrong}")).to_be_visible()
        hand.fill("cells", "circuit")
        page.keyboard.press("Enter")
        expect(yaml).to_have_text("brain:\n  interventions:\n    - {silence: circuit}\n")
        page.get_by_role("region", name="Texts").get_by_role("button", name="Copy").click()
        expect(page.get_by_text("The interventions were copied.")).to_be_visible()
        assert page.evaluate("() => navigator.clipboard.readText()") == yaml.inner_text()
        page.keyboard.press("Control+Shift+Enter")
        expect(page.get_by_role("link", name="Cockpit")).to_have_attribute("aria-current", "page")
        seen(page, lambda: here.session.now_ns, lambda now_ns: now_ns > 1_000_000_000)
        page.get_by_role("button", name="Pause").click()
        page.get_by_role("button", name="Play").wait_for()
        assert here.session.run is not here.run
        assert abs(here.session.run.world.model_motion("husky").angular[2]) < 1e-3  # it turns, else


def test_the_experiment_of_the_paper_is_drawn_from_nothing_and_passes(alone: tuple[Hand, Path]):
    hand, file = alone
    draw_wheels(hand)
    draw_eyes(hand)
    hand.click("button", "Save")
    expect(hand.page.get_by_text(f"Saved {file}.")).to_be_visible()
    assert read_bibi(file).transfer_function == (
        *read_bibi(PAPER / "listing1.bibi").transfer_function,
        *read_bibi(PAPER / "listing2.bibi").transfer_function,
    )
    hand.click("button", "Run")
    page = hand.page
    expect(page.get_by_role("link", name="Cockpit")).to_have_attribute("aria-current", "page")
    page.get_by_role("link", name="Functions", exact=True).click()  # draws less than the scene meanwhile
    expect(page.get_by_role("timer")).to_contain_text("10.00 s", timeout=2 * PATIENCE_MS)
    page.get_by_role("link", name="Cockpit").click()
    criteria = page.get_by_role("list", name="Criteria")
    for criterion in ("turns_on_the_spot", "reaches_left", "reaches_right", "turns_on_the_spot_again"):
        expect(criteria).to_contain_text(f"{criterion}, met")
    assert hand.actions < MOST_ACTIONS, hand.actions
