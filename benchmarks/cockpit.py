"""What the cockpit costs: the same run without a server, with one that nobody visits, and with one client.

The room of the shipped experiment with 20 more bodies, the camera of 320x240 pixels at 50 Hz and 1000 more
cells that fire 20 000 times a second. The client is a process of its own and hears what the page shows:
reports, scene, poses, camera, spikes and devices. The runs take turns of a tenth of a second in real time, as
people watch them, in changing order. With a client the result is the median, over the rounds, of the CPU time
of this process that a step takes more than without a server. Without one, it takes so little more that the
difference of two runs hardly shows it: the result is the mean CPU time of all that the session does after a
step, with its snapshots, less that of a function that does nothing, in the run without a server.

Then the page of the same run, in Debian's Chromium at 1280x720 and without a graphics card: the time from the
request to the first picture of the room, the median of new visits, and the frames a second while the run
plays and the raster gets its 20 000 spikes a second. Both come with the CPU time of the page's main thread,
which other work on the machine does not lengthen: at 30 frames a second each has 33 ms.

Last a recording of that run: the time from a key of the timeline until time and camera of another second are
drawn, forward and back.

    python benchmarks/cockpit.py [SECONDS]
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from importlib.resources import files
from operator import sub
from pathlib import Path
from shutil import copytree
from statistics import median
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from conditions import print_conditions
from nrp_cockpit.session.controls import services_of
from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.session.session import Mode
from nrp_cockpit.wire.guard import Guard
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.server import Server
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from nrp_core.cle.loop import ClosedLoop
from nrp_core.cle.pacing import Paced
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder

if TYPE_CHECKING:
    from playwright.sync_api import Page

ALONE, WATCHED, UNSERVED = "no client", "one client", "no server"
LIMITS_US = {ALONE: 20.0, WATCHED: 1000.0}
ROUND_S, WARM_UP_S = 0.1, 1.0
BODIES, CELLS, RATE_HZ = 20, 1000, 20.0

FIRST_PICTURE_MS, FRAMES_HZ = 1000.0, 30.0
VISITS, WATCHED_S = 5, 5.0
SCRUB_MS, RECORDED_S = 500.0, 6
CHROMIUM = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
    "--disable-accelerated-2d-canvas",
)
SEEN = "() => performance.getEntriesByName('first-picture')[0]?.startTime"
FRAMES = """wall_ms => new Promise((done) => {
    const began = performance.now();
    let frames = 0;
    const next = (now) => {
        frames++;
        if (now - began < wall_ms) requestAnimationFrame(next);
        else done((frames * 1000) / (now - began));
    };
    requestAnimationFrame(next);
})"""

SCRUB = """([key, t]) => new Promise((done) => {
    const camera = document.querySelector('[role=img][aria-label="The image of /husky/camera"]');
    const timer = document.querySelector('[role=timer]');
    const slider = document.querySelector('[role=slider][aria-label="Simulated time"]');
    const before = camera.toDataURL();
    const began = performance.now();
    slider.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
    const look = () => {
        const there = timer.innerText.startsWith(t) && camera.toDataURL() !== before;
        if (there) done(performance.now() - began);
        else requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
})"""

HEARD = re.compile(
    "/cockpit/.*|/scene|/tf|/gazebo/model_states|/husky/camera|/husky/cmd_vel|/brain/(?!projections/).*"
)
"""The topics that the client hears: those that the page subscribes to when it is opened."""

BODY = """
    <model name="box{0}"><pose>{1} {2} 0.2 0 0 0</pose><link name="link">
      <inertial><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>
      <collision name="box"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision>
      <visual name="box"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></visual>
    </link></model>"""
NOISE = f"""
sim.Population({CELLS}, sim.SpikeSourcePoisson(rate={RATE_HZ}), label="noise")
"""


def experiment(folder: Path) -> Experiment:
    """Write the experiment and return it."""
    copytree(Path(str(files("nrp_experiments") / "braitenberg_husky")), folder, dirs_exist_ok=True)
    boxes = "".join(BODY.format(n, -4 + n % 5, 1.5 + 0.5 * (n // 5)) for n in range(BODIES))
    _edit(folder / "room.sdf", "</world>", f"{boxes}</world>")
    _edit(folder / "husky.sdf", "<update_rate>30</update_rate>", "<update_rate>50</update_rate>")
    brain = folder / "brain.py"
    brain.write_text(brain.read_text() + NOISE)
    return load_experiment(folder / "experiment.yaml")


def _edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text, f"{path.name} has no {old}"
    path.write_text(text.replace(old, new))


@contextmanager
def served(run: Run) -> Iterator[str]:
    """Serve a run that this thread steps; give the address."""
    hub, guard = Hub(), Guard()
    session = LiveSession(run, hub)
    session.mode = Mode.RUNNING
    hub.services = services_of(session)
    server = Server(hub, guard=guard)
    session.reports.all()
    yield f"ws://127.0.0.1:{server.port}/?token={guard.token}"
    server.close()


@contextmanager
def client(address: str) -> Iterator[subprocess.Popen[str]]:
    """Let another process hear the run until the server is gone."""
    command = [sys.executable, __file__, address]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process


def hear(address: str) -> int:
    """Hear what the page shows; print the number of messages and of bytes when the server is gone."""
    messages = received = 0
    with connect(address, max_size=None, proxy=None) as connection, suppress(ConnectionClosed):
        while True:
            frame = connection.recv()
            if isinstance(frame, bytes):
                messages, received = messages + 1, received + len(frame)
            elif (message := json.loads(frame))["op"] == "advertise":
                heard = [one["id"] for one in message["channels"] if HEARD.fullmatch(one["topic"])]
                wanted = [{"id": number, "channelId": number} for number in heard]
                connection.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
                print("ready", flush=True)
    print(messages, received)
    return 0


def spent_us(run: Run, until_s: float) -> float:
    """Return the CPU time of a step, us."""
    began, steps = time.process_time(), run.loop.steps
    run.run_until(round(until_s, 3))
    return (time.process_time() - began) / (run.loop.steps - steps) * 1e6


class Clocked:
    """A hook after the steps of a run, with the CPU time that it takes."""

    def __init__(self, run: Run, hook: Callable[[ClosedLoop], None]) -> None:
        self._hook = hook
        run.loop.hooks.after_step.append(self)
        self.begin()

    def begin(self) -> None:
        """Forget what was measured."""
        self._spent_ns = self._calls = 0

    def __call__(self, loop: ClosedLoop) -> None:
        began_ns = time.thread_time_ns()
        self._hook(loop)
        self._spent_ns += time.thread_time_ns() - began_ns
        self._calls += 1

    @property
    def mean_us(self) -> float:
        """CPU time of a call."""
        return self._spent_ns / self._calls / 1e3


def _nothing(_loop: ClosedLoop) -> None: ...


def measure(duration_s: float) -> tuple[dict[str, list[float]], float]:
    """Return the CPU time of a step in each round, by who watches, and of the session alone, us."""
    with ExitStack() as stack:
        made = experiment(Path(stack.enter_context(TemporaryDirectory())))
        names = (UNSERVED, *LIMITS_US)
        runs = {name: stack.enter_context(Run(made)) for name in names}
        runs[UNSERVED].loop.pacing = Paced()
        serving = ExitStack()
        addresses = {name: serving.enter_context(served(runs[name])) for name in LIMITS_US}
        alone = Clocked(runs[ALONE], runs[ALONE].loop.hooks.after_step.pop())
        nothing = Clocked(runs[UNSERVED], _nothing)
        with client(addresses[WATCHED]) as process:
            for run in runs.values():
                run.run_until(WARM_UP_S)
            alone.begin()
            nothing.begin()
            rounds: dict[str, list[float]] = {name: [] for name in names}
            for i in range(1, int((duration_s - WARM_UP_S) / ROUND_S) + 1):
                for name in (*names[i % 3 :], *names[: i % 3]):
                    rounds[name].append(spent_us(runs[name], WARM_UP_S + i * ROUND_S))
            simulated_s = runs[WATCHED].now_s
            serving.close()
            assert process.stdout is not None
            messages, received = map(int, process.stdout.read().split())
    print(f"{messages / simulated_s:.0f} messages and {received / simulated_s / 1e6:.1f} MB a second")
    return rounds, alone.mean_us - nothing.mean_us


@contextmanager
def command(file: Path) -> Iterator[str]:
    """Run the command as people do; give the address of its page."""
    words = [sys.executable, "-m", "nrp_core", "cockpit", str(file), "--no-browser"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.terminate()


def page() -> bool:
    """Measure the page; return whether it is as fast as it should be."""
    from playwright.sync_api import sync_playwright

    began = time.monotonic()
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        experiment(folder)
        address = stack.enter_context(command(folder / "experiment.yaml"))
        print(f"{time.monotonic() - began:.1f} s from the command to its address")
        playwright = stack.enter_context(sync_playwright())
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=list(CHROMIUM))
        seen_ms, spent_ms = [], []
        for _ in range(VISITS):
            visit = browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
            clock = thread_clock(visit)
            visit.goto(address)
            seen_ms.append(float(visit.wait_for_function(SEEN).json_value()))
            spent_ms.append(clock())
            if len(seen_ms) < VISITS:
                visit.context.close()
        visit.get_by_role("button", name="Play").click()
        before_ms = clock()
        frames_hz = float(visit.evaluate(FRAMES, WATCHED_S * 1000))
        frame_ms = (clock() - before_ms) / max(frames_hz * WATCHED_S, 1)
        browser.close()
    first_ms = median(seen_ms)
    print(f"the first picture takes {first_ms:.0f} ms, at most {FIRST_PICTURE_MS:g}; {_rounded(seen_ms)}")
    print(f"of these {median(spent_ms):.0f} ms are CPU time of the page's main thread; {_rounded(spent_ms)}")
    print(
        f"{frames_hz:.0f} frames a second while it plays, at least {FRAMES_HZ:g}; {frame_ms:.1f} ms CPU each"
    )
    return first_ms <= FIRST_PICTURE_MS and frames_hz >= FRAMES_HZ


def scrubbing() -> bool:
    """Measure how long other seconds of a recording take to be seen; return whether that is short enough."""
    from playwright.sync_api import sync_playwright

    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        with Run(experiment(folder / "husky")) as run:
            recorded = RecordingFolder(run, folder / "recording")
            run.run_until(RECORDED_S)
            recorded.close("finished")
        address = stack.enter_context(command(folder / "recording"))
        playwright = stack.enter_context(sync_playwright())
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=list(CHROMIUM))
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(address)
        page.wait_for_function(SEEN)
        page.get_by_role("slider", name="Simulated time").press("Home")
        page.get_by_role("timer").get_by_text("0.00 s").wait_for()
        page.get_by_role("img", name="The image of /husky/camera").wait_for()
        there = [("PageUp", t_s) for t_s in range(1, RECORDED_S)]
        back = [("PageDown", t_s) for t_s in reversed(range(1, RECORDED_S - 1))]
        taken_ms = [float(page.evaluate(SCRUB, [key, f"{t_s}.00"])) for key, t_s in there + back]
        browser.close()
    longest_ms = max(taken_ms)
    print(f"any recorded second is seen in {longest_ms:.0f} ms, at most {SCRUB_MS:g}; {_rounded(taken_ms)}")
    return longest_ms <= SCRUB_MS


def thread_clock(page: Page) -> Callable[[], float]:
    """Return a function that gives the CPU time of a page's main thread so far, ms."""
    devtools = page.context.new_cdp_session(page)
    devtools.send("Performance.enable", {"timeDomain": "threadTicks"})

    def now_ms() -> float:
        metrics = devtools.send("Performance.getMetrics")["metrics"]
        return 1000 * float(next(each["value"] for each in metrics if each["name"] == "ThreadTime"))

    return now_ms


def _rounded(rounds_ms: list[float]) -> str:
    return "rounds " + " ".join(f"{each:.0f}" for each in rounds_ms)


def main(duration_s: float) -> int:
    print_conditions()
    rounds, alone_us = measure(duration_s)
    print(f"a step takes {median(rounds[UNSERVED]):.0f} us of CPU time")
    pairs_us = {name: median(map(sub, rounds[name], rounds[UNSERVED])) for name in LIMITS_US}
    added_us = {**pairs_us, ALONE: alone_us}
    for name, limit_us in LIMITS_US.items():
        print(f"{name:<12}{added_us[name]:7.0f} us more a step, at most {limit_us:g}")
    print(f"the difference of the runs themselves is {pairs_us[ALONE]:.0f} us without a client")
    well = all(added_us[name] <= limit_us for name, limit_us in LIMITS_US.items())
    return 0 if all([page(), scrubbing(), well]) else 1


if __name__ == "__main__":
    first = sys.argv[1] if len(sys.argv) > 1 else "20"
    sys.exit(hear(first) if first.startswith("ws:") else main(float(first)))
