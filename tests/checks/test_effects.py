"""Effects that are lost in silence: what is said of them, and of what nothing is said because it works."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from textwrap import indent

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Finding, Level

TWIST = "Topic('/husky/cmd_vel', geometry_msgs.msg.Twist)"
HEAD = f"""\
import os
import signal
import sys
from collections import deque
from os import _exit as leave

import helpers
import numpy as np
from geometry_msgs.msg import Twist, Vector3

GAINS = {{"left": 2.0}}
HISTORY = []
LATEST = deque(maxlen=5)
WEIGHTS = np.zeros(3)
CACHE = {{}}
network = None
total = 0.0


class Filter:
    def __init__(self):
        self.level, self.seen = 0.0, []

    def of(self, x):
        self.level += 0.1 * (x - self.level)
        return self.level

    def noted(self, x):
        self.seen.append(x)

    def last(self):
        return self.seen[-1]


FILTER = Filter()


def smoothed(x, old=[]):
    old.append(x)
    return sum(old) / len(old)


def cleared(x, old=None):
    old = [] if old is None else old
    old.append(x)
    return old


def load():
    global network
    network = len(GAINS)
    HISTORY.append(network)


load()


@nrp.MapSpikeSink("wheel", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.MapVariable("n", initial_value=0)
@nrp.MapVariable("rows", initial_value=[])
@nrp.Neuron2Robot({TWIST})
def drive(t, wheel, eye, n, rows):
    used = (wheel, eye, n, rows)
    eye.rate = 1.0
"""
TAIL = "    return Twist() if used else None\n"

Check = Callable[[str], list[Finding]]


@pytest.fixture
def check(husky: Path, functions: Path) -> Check:
    """Return a function that gives all findings about a body but the latency of the loop."""

    def checked(body: str) -> list[Finding]:
        (husky / "helpers.py").write_text("LEVEL = 1.0\n")
        (husky / "drive.py").write_text(HEAD + indent(body, "    ") + "\n" + TAIL)
        found = validate_file(functions, [f"transfer_functions=[{husky}/drive.py]"])
        return [finding for finding in found if finding.code.name != "NRP238"]

    return checked


LOST = [
    "Twist(linear=Vector3(x=1.0))",
    "go = Twist()\ngo.linear.x = wheel.voltage",
    "go = Twist(linear=Vector3())\nif t > 1:\n    go.angular.z += 1.0",
]
KEPT = [
    "global total\ntotal += 1",
    "global total\nif t > 1:\n    total = wheel.voltage",
    "HISTORY.append(t)",
    "LATEST.popleft()",
    "GAINS['left'] = t",
    "GAINS['left'] += 1",
    "del HISTORY[0]",
    "WEIGHTS[0] = t",
    "WEIGHTS[:] = 0.9 * WEIGHTS",
    "WEIGHTS[:2] = t",
    "Filter.level = 3",
    "FILTER.level = 3",
    "FILTER.seen.append(3)",
    "cleared.calls = 3",
    "helpers.LEVEL = t",
]
ENDS = [
    "exit()",
    "quit(3)",
    "if t > 3:\n    sys.exit('done')",
    "os._exit(0)",
    "leave(0)",
    "raise SystemExit",
    "raise SystemExit(3)",
]


@pytest.mark.parametrize(
    ("code", "body"),
    [
        (code, one)
        for code, bodies in (("NRP355", LOST), ("NRP301", KEPT), ("NRP243", ENDS))
        for one in bodies
    ],
)
def test_an_effect_that_is_lost_is_reported_once(check: Check, code: str, body: str) -> None:
    (finding,) = check(body)
    assert (finding.code.name, finding.level) == (code, Level.WARNING)
    assert finding.path is not None
    assert finding.path.name == "drive.py"


WORKS = {
    "calls": "print(t)\nrows.value.append(t)\nn.value += 1\nt > 3 and print(t)\nsys.stdout.write('x')",
    "texts": "'a comment'\n...\nif t > 3:\n    pass\nelse:\n    None",
    "tests": "try:\n    rows.value[3]\n    eye.late\nexcept LookupError:\n    eye.rate = 0.0",
    "streams": "out = []\nprint(out)\nsys.stdout | out",
    "sent": "go = Twist()\ngo.linear.x = 1.0\nif t > 1:\n    return go",
    "kept": "go = Twist()\ngo.linear.x = 1.0\nrows.value.append(go)",
    "inner": "go = Twist()\ngo.linear.x = 1.0\ndef made():\n    return go\nrows.value = made()",
    "shown": "level = 0.0\nlevel += t\nprint(f'{level}')",
    "devices": "both = [eye, eye]\nboth[0].rate = 3.0",
    "alias": "alias = eye\nalias.rate = 3.0\nshared = rows.value\nshared += [t]",
    "returned": "mine = []\nmine.append(t)\nrows.value = mine",
    "read only": "eye.rate = GAINS['left'] + network + sum(HISTORY) + WEIGHTS.sum() + total + helpers.LEVEL",
    "local": "HISTORY = []\nHISTORY.append(t)\nrows.value = HISTORY\nnew = {}\nnew['a'] = t\nprint(new)",
    "once": "global network\nif network is None:\n    network = len(GAINS)\nprint(network)",
    "memo": "if 'a' not in CACHE:\n    CACHE['a'] = float('3')\neye.rate = CACHE['a']",
    "scratch": "WEIGHTS[:] = wheel.voltage\nWEIGHTS[...] = t\nprint(WEIGHTS)",
    "objects": "own = Filter()\neye.rate = own.of(t)\nown.noted(t)\nprint(FILTER.last(), FILTER.level)",
    "defaults": "print(cleared(t), smoothed(t, []), smoothed(t, old=[]))",
    "variables": "rows.value.append(t)\nrows.value[0] = t\nn.value = n.value + 1",
    "closure": "level = 0\ndef up():\n    nonlocal level\n    level += 1\n    return level\nprint(up())",
    "own exit": "exit = print\nexit()",
    "asks": "os.kill(os.getpid(), 0)",
    "raises": "if t < 0:\n    raise ValueError('no')",
    "values": "n = n.value\neye.rate = n",
    "scaled": "n = n.value * 100.0\neye.rate = n",
    "both": "last = n.value\nn.value = last + 1\neye.rate = last",
    "is": "if n.value is None or n.value is True:\n    n.value = 3",
    "asserts": "assert t >= 0, 'the time'\nassert (t >= 0)",
}


@pytest.mark.parametrize("body", WORKS.values(), ids=WORKS)
def test_code_that_works_is_not_reported(check: Check, body: str) -> None:
    assert [str(one) for one in check(body) if one.level is not Level.NOTE] == []


def found_in(husky: Path, text: str) -> list[Finding]:
    (husky / "own.py").write_text(text)
    found = validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky}/own.py]"])
    return [finding for finding in found if finding.code.name != "NRP238"]


def test_state_that_two_functions_share_through_a_factory_is_found(husky: Path) -> None:
    text = (
        "def make(name):\n"
        "    calls = 0\n"
        "    @nrp.Robot2Neuron()\n"
        "    def f(t):\n        nonlocal calls\n        calls += 1\n"
        "    f.name = name\n    return f\n"
        "one = make('one')\n"
    )
    (finding,) = found_in(husky, text)
    assert (finding.code.name, finding.line) == ("NRP301", 6)


def test_functions_that_no_transfer_function_uses_may_end_the_process(husky: Path) -> None:
    text = (
        "import sys\n"
        "def main():\n    global state\n    state = 1\n    sys.exit(state)\n"
        "@nrp.Robot2Neuron()\ndef f(t):\n    pass\n"
        "if __name__ == '__main__':\n    main()\n"
    )
    assert found_in(husky, text) == []


VARIABLE = (
    "@nrp.MapVariable('n', initial_value=0)\n"
    "@nrp.MapSpikeSource('eye', nrp.brain.sensors[0], nrp.poisson)\n"
    "@nrp.Robot2Neuron()\n"
    "def f(t, n, eye):\n    eye.rate = 1.0\n"
)


@pytest.mark.parametrize(
    "body",
    [
        "n = n.value + 1",
        "n = 2 * n.value",
        "n = n.value + 1\neye.rate = n",
        "if t > 1:\n    n = n.value - t\neye.rate = n",
    ],
)
def test_a_variable_that_is_replaced_by_its_value_is_reported(husky: Path, body: str) -> None:
    (finding,) = found_in(husky, VARIABLE + indent(body, "    "))
    assert (finding.code.name, finding.level) == ("NRP253", Level.WARNING)


@pytest.mark.parametrize(
    "body",
    [
        "n = n.value\neye.rate = n",
        "n = 100.0 * n.value\neye.rate = n",
        "n.value = n.value + 1",
        "m = n.value + 1\nn.value = m",
        "n.value += 1\nn = n.value + 100.0\neye.rate = n",
    ],
)
def test_a_variable_may_be_replaced_by_its_value_for_the_rest_of_a_call(husky: Path, body: str) -> None:
    assert found_in(husky, VARIABLE + indent(body, "    ")) == []


FUNCTION = "@nrp.Robot2Neuron()\ndef {}(t):\n    pass\n"
GONE = [
    "if False:\n" + indent(FUNCTION.format("f"), "    "),
    "if 1:\n    pass\nelse:\n" + indent(FUNCTION.format("f"), "    "),
    "def make():\n    return 1\n" + indent(FUNCTION.format("f"), "    ") + "make()\n",
    "DEBUG = False\nif DEBUG:\n" + indent(FUNCTION.format("f"), "    "),
    "for side in []:\n" + indent(FUNCTION.format("f"), "    "),
]


@pytest.mark.parametrize("text", GONE, ids=range(len(GONE)))
def test_a_function_that_the_file_never_reaches_is_noted(husky: Path, text: str) -> None:
    (finding,) = found_in(husky, text + FUNCTION.format("g"))
    assert (finding.code.name, finding.level) == ("NRP239", Level.NOTE)


def test_functions_that_are_reached_elsewhere_are_not_reported(husky: Path) -> None:
    inner = indent(FUNCTION.format("f"), "    ")
    made = "    return f\nmake(True)\nmake(False)\n"
    for text in (
        f"MODE = 'a'\nif MODE == 'a':\n{inner}else:\n{inner}",
        f"def make(is_right):\n    if is_right:\n        return 3\n{inner}{made}",
    ):
        assert found_in(husky, text) == []


def test_functions_in_classes_and_unread_factories_are_noted(husky: Path) -> None:
    inner = indent(FUNCTION.format("f"), "    ")
    for text in (f"class A:\n{inner}", f"def make():\n{inner}\n"):
        (finding,) = found_in(husky, text + FUNCTION.format("g"))
        assert (finding.code.name, finding.level) == ("NRP239", Level.NOTE)
