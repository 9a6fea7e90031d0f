"""Files whose transfer functions come of loops and of functions of their own, and the modules beside them."""

from __future__ import annotations

import shutil
import sysconfig
from collections.abc import Callable
from pathlib import Path

import nrp_experiments
import pytest

from nrp_core.checks.code.declarations import Declarations
from nrp_core.checks.validate import validate_file
from nrp_core.dsl.loading import python_listing
from nrp_core.findings import Finding, Level

SHIPPED = Path(nrp_experiments.__path__[0])

Changed = Callable[..., list[Finding]]


@pytest.fixture
def changed(tmp_path: Path) -> Changed:
    """Return a function that replaces a text in a file of a shipped experiment, and gives what is found."""

    def found_in(experiment: str, file: str, old: str, new: str) -> list[Finding]:
        for name in (experiment, "bodies"):
            shutil.copytree(SHIPPED / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
        path = tmp_path / experiment / file
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))
        found = validate_file(tmp_path / experiment)
        return [finding for finding in found if finding.level is not Level.NOTE]

    return found_in


@pytest.mark.parametrize(
    ("old", "new", "code", "message"),
    [
        ("_alpha/cmd_pos", "_alpa/cmd_pos", "NRP212", "no topic '/hexapod/front_left_alpa/cmd_pos'"),
        ("nrp.brain.swing[cells]", "nrp.brain.swin[cells]", "NRP211", "did you mean 'swing'?"),
        ("(CELLS * number, ", "(CELLS * (number + 6), ", "NRP211", "selects no neuron"),
        ('"rear_left"', '"back_left"', "NRP212", "did you mean '/hexapod/rear_left_alpha/cmd_pos'?"),
        ("tau_fall=QUICK_MS", "taufall=QUICK_MS", "NRP240", "did you mean 'tau_fall'?"),
        ("forward.rate", "forward.voltage", "NRP240", "has no attribute 'voltage'"),
        ('MapSpikeSink("lifting"', 'MapSpikeSink("lift"', "NRP219", "did you mean 'lifting'?"),
    ],
)
def test_functions_of_a_loop_are_checked(
    changed: Changed, old: str, new: str, code: str, message: str
) -> None:
    found = changed("walking_hexapod", "walk.py", old, new)
    assert {finding.code.name for finding in found} == {code}
    assert any(message in finding.message for finding in found)
    assert all(finding.line is not None for finding in found)


@pytest.mark.parametrize(
    ("old", "new", "code", "message"),
    [
        ("group(nrp.brain.retina)", "group(nrp.brain.retna)", "NRP211", "did you mean 'retina'?"),
        ("neurons(4, group(nrp.brain.m", "neurons(5, group(nrp.brain.m", "NRP211", "selects no neuron"),
        ("sides.rate = 0.0", "sides.voltage = 0.0", "NRP240", "has no attribute 'voltage'"),
        ("group(nrp.brain.retina)", "group()", "NRP240", "missing a required argument: 'population'"),
    ],
)
def test_functions_of_the_file_are_followed(
    changed: Changed, old: str, new: str, code: str, message: str
) -> None:
    (finding, *_) = changed("following_head", "gaze.py", old, new)
    assert (finding.code.name, message in finding.message) == (code, True), finding.message


HELPERS = """\
import math

GAIN = 10.0
state = None


def scaled(x, by=GAIN):
    return math.floor(x * by)
"""
USES = """\
import helpers
from helpers import GAIN, scaled

helpers.own = scaled(2.0)

@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.Robot2Neuron()
def f(t, eye):
    eye.rate = GAIN * scaled(t, by=2.0) + helpers.GAIN + helpers.own
"""


def checked(husky: Path, helpers: str, uses: str = USES) -> list[str]:
    (husky / "helpers.py").write_text(helpers)
    (husky / "own.py").write_text(uses)
    found = validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky}/own.py]"])
    return [
        f"{finding.path and finding.path.name}:{finding.line} {finding.code.name} {finding.message}"
        for finding in found
        if finding.level is not Level.NOTE
    ]


def test_a_valid_module_beside_the_file_yields_no_finding(husky: Path) -> None:
    assert checked(husky, HELPERS) == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("(x, by=GAIN):", "(x, by=GAIN)", "helpers.py:7 NRP218 this is not Python: expected ':'"),
        ("x * by", "y * by", "helpers.py:8 NRP246 nothing defines the name 'y'"),
        ("import math", "import maht", "helpers.py:1 NRP218 there is no module 'maht'"),
        ("(x, by=GAIN)", "(by)", "own.py:9 NRP240 scaled(by): multiple values for argument 'by'"),
        ("GAIN = 10.0\n", "GAINS = GAIN = 10.0\ndel GAINS\n", ""),
    ],
)
def test_a_module_beside_the_file_is_checked_as_well(husky: Path, old: str, new: str, said: str) -> None:
    found = checked(husky, HELPERS.replace(old, new))
    assert (found == []) if not said else any(one.startswith(said) for one in found), found


def test_names_that_a_module_beside_the_file_lacks_are_reported(husky: Path) -> None:
    (found,) = checked(husky, HELPERS, USES.replace("helpers.GAIN", "helpers.GAINS"))
    assert found == "own.py:9 NRP240 'helpers' has no 'GAINS'; did you mean 'GAIN'?"


def test_a_loop_is_followed_only_over_known_items(husky: Path) -> None:
    text = (
        "import os\n"
        "SIDES = []\n"
        "SIDES.append('left')\n"
        "def make(side):\n"
        "    @nrp.Neuron2Robot(Topic('/own/' + side, std_msgs.msg.Float64))\n"
        "    def send(t):\n        return 1.0\n"
        "for side in SIDES:\n    make(side)\n"
        "@nrp.MapRobotSubscriber('own', Topic('/own/left', std_msgs.msg.Float64))\n"
        "@nrp.Neuron2Robot()\n"
        "def hear(t, own):\n    print(own.value)\n"
    )
    found = checked(husky, HELPERS, text)
    assert [one for one in found if "NRP212" not in one] == []  # a warning at most: what is made may serve it
    (husky / "own.py").write_text(text)
    every = validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky}/own.py]"])
    assert "'send' is declared only when the file is executed" in [finding.message for finding in every]
    assert not [finding for finding in every if finding.level is Level.ERROR]


def test_any_file_can_be_followed() -> None:
    for path in sorted(Path(sysconfig.get_paths()["stdlib"]).glob("*.py"))[::12]:
        declared = Declarations(python_listing(path))
        assert declared.functions == []


@pytest.mark.parametrize(
    "loop",
    [
        "for i in range(100000):\n    for j in range(1000):\n        N = i * j\n",
        "for name in open(__file__):\n    if name:\n        break\n",
        "while True:\n    N = 3\n    break\n",
        "for i in range(3):\n    if i == 1:\n        continue\n    break\nelse:\n    N = 1 / 0\n",
        "def find(x):\n    for one in x:\n        if one in open(one): return 1\nN = find('a')\n",
    ],
)
def test_code_that_is_not_followed_to_its_end_yields_no_finding(husky: Path, loop: str) -> None:
    assert checked(husky, HELPERS, loop + USES) == []


def test_an_infinite_recursion_is_abandoned(husky: Path) -> None:
    text = "def deep(n):\n    return deep(n + 1)\nN = deep(0)\n"
    assert checked(husky, HELPERS, text + USES) == []
