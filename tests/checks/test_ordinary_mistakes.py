"""Ordinary mistakes in the experiment of a tutorial are found at their lines."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from golden import Golden

import nrp_core
from nrp_core.checks.validate import validate_file
from nrp_core.errors import NrpError
from nrp_core.findings import Finding, Level

PAGE = (Path(__file__).parents[2] / "docs" / "tutorial" / "own-experiment.md").read_text("utf-8")
FILES = {
    name: next(
        block for block in re.findall(r"```\w+\n(.*?)```", PAGE, re.S) if block.startswith(f"# {name}")
    )
    for name in ("brain.py", "functions.py", "crossed.yaml")
}
YAML, CODE, BRAIN = "crossed.yaml", "functions.py", "brain.py"
HUSKY = "duration: 20 s\nworld: {robots: {husky: {pose: [0, 0, %s]}}}"
MISTAKES = [
    # the experiment
    ("a tab", YAML, "duration: 20 s", "\tduration: 20 s", "NRP200", 4),
    ("an indented line", YAML, "duration: 20 s", "  duration: 20 s", "NRP200", 4),
    ("a missing colon", YAML, "duration: 20 s", "duration 20 s", "NRP200", 4),
    ("a missing brace", YAML, "populations: null}", "populations: null", "NRP200", 6),
    ("a misspelt key", YAML, "duration: 20 s", "duraton: 20 s", "NRP201", 4),
    ("a time without a unit", YAML, "duration: 20 s", "duration: 20", "NRP202", 4),
    ("a negative duration", YAML, "duration: 20 s", "duration: -20 s", "NRP202", 4),
    ("a misspelt brain", YAML, "brain.py", "brian.py", "NRP204", 5),
    ("a missing file", YAML, "[functions.py]", "[function.py]", "NRP204", 6),
    ("a misspelt base", YAML, "no_red", "no_rd", "NRP200", 3),
    ("a misspelt backend", YAML, "duration: 20 s", "duration: 20 s\nworld: {backend: mujco}", "NRP205", 5),
    ("a misspelt topic of an event", YAML, "/screens/left/color", "/screens/lft/color", "NRP212", 7),
    ("a misspelt colour", YAML, "value: red", "value: raed", "NRP212", 7),
    ("a misspelt robot", YAML, "{model: husky,", "{model: huskey,", "NRP213", 11),
    ("a misspelt visual", YAML, "left_vr_screen/", "left_screen/", "NRP213", 11),
    ("a misspelt event", YAML, "event: red,", "event: raed,", "NRP213", 12),
    ("an event after the end", YAML, "at: 2 s", "at: 30 s", "NRP248", 7),
    ("a limit beyond the end", YAML, "time: 15 s", "time: 150 s", "NRP248", 12),
    ("a pose in degrees", YAML, "duration: 20 s", HUSKY % "0.2, 0, 0, 90", "NRP249", 5),
    ("upside down", YAML, "duration: 20 s", HUSKY % "0.5, 180 deg, 0, 0", "NRP370", 5),
    ("under the floor", YAML, "duration: 20 s", HUSKY % "-2, 0, 0, 0", "NRP292", 5),
    ("in the air", YAML, "duration: 20 s", HUSKY % "20, 0, 0, 0", "NRP306", 5),
    # transfer functions
    ("Python 2", CODE, "    red = nrp", "    print 'seen'\n    red = nrp", "NRP210", 12),
    ("a function without a colon", CODE, "camera, left, right):", "camera, left, right)", "NRP210", 11),
    ("an import that is missing", CODE, "import Twist, Vector3", "import Twist", "NRP246", 20),
    ("a misspelt module", CODE, "from geometry_msgs", "from geometry_mgs", "NRP210", 3),
    ("a misspelt message", CODE, "import Image", "import Imge", "NRP210", 4),
    ("a misspelt name", CODE, "300 * red.left", "300 * rad.left", "NRP246", 13),
    ("a misspelt topic", CODE, "/husky/camera", "/husky/camra", "NRP212", 7),
    ("a topic of another type", CODE, '"/husky/camera", Image', '"/husky/camera", Twist', "NRP212", 7),
    ("a misspelt population", CODE, "brain.eyes[0]", "brain.eys[0]", "NRP211", 8),
    ("a neuron beyond the population", CODE, "brain.eyes[0]", "brain.eyes[2]", "NRP211", 8),
    ("a misspelt device", CODE, "eyes[0], nrp.poisson", "eyes[0], nrp.poison", "NRP210", 8),
    ("a misspelt attribute", CODE, "0.002 * min(left.rate", "0.002 * min(left.rat", "NRP240", 20),
    ("another device's attribute", CODE, "0.002 * min(left.rate", "0.002 * min(left.voltage", "NRP240", 20),
    ("a topic for its message", CODE, "detect_red(camera.value)", "detect_red(camera)", "NRP240", 12),
    ("a device for its rate", CODE, "(right.rate - left.rate)", "(right - left)", "NRP240", 21),
    ("a parameter without a mapping", CODE, "left, right):", "left, right, gain):", "NRP210", 7),
    ("a mapping without a parameter", CODE, "camera, left, right):", "camera, left):", "NRP210", 9),
    ("a decorator that is not called", CODE, "@nrp.Robot2Neuron()", "@nrp.Robot2Neuron", "NRP210", 10),
    ("no time", CODE, "def drive(t, left", "def drive(left", "NRP210", 16),
    ("a number for a message", CODE, "return Twist(", "return left.rate\n    return Twist(", "NRP240", 16),
    ("too many arguments", CODE, "Vector3(0, 0, 0.3", "Vector3(0, 0, 0, 0.3", "NRP240", 21),
    ("a negative rate", CODE, "50 + 300 * red.left, ", "-50, ", "NRP240", 13),
    ("a source that is never set", CODE, "left.rate, right.rate = 50", "left.rate = 50", "NRP231", 9),
    ("not a number", CODE, "50 + 300 * red.left, ", 'float("nan") * red.left, ', "NRP240", 13),
    # the brain
    ("a misspelt function", BRAIN, "sim.setup", "sim.setpu", "NRP208", 4),
    ("a misspelt parameter of a cell", BRAIN, "tau_refrac=2.0", "tau_ref=2.0", "NRP208", 5),
    ("a synapse beyond the population", BRAIN, "(1, 0)", "(2, 0)", "NRP208", 8),
    ("weights that are too small", BRAIN, "weight=20.0", "weight=0.02", "NRP377", 5),
    ("weights that are too large", BRAIN, "weight=20.0", "weight=20000", "NRP297", 5),
]  # fmt: skip


@pytest.fixture
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the experiment, the same for all tests, so that its brain is built once."""
    path = tmp_path_factory.getbasetemp() / "crossed"
    path.mkdir(exist_ok=True)
    for name, text in FILES.items():
        (path / name).write_text(text)
    return path


def change(folder: Path, file: str, old: str, new: str) -> int:
    """Replace a text in a file; return the line of the change."""
    text = FILES[file]
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1))
    return text[: text.index(old)].count("\n") + 1


def warnings_about(folder: Path) -> list[Finding]:
    return [one for one in validate_file(folder / YAML) if one.level is not Level.NOTE]


def test_the_experiment_of_the_readme_is_met_with_silence(folder: Path) -> None:
    assert warnings_about(folder) == []


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("file", "old", "new", "code", "line"), [one[1:] for one in MISTAKES], ids=[one[0] for one in MISTAKES]
)
def test_a_mistake_is_found_at_its_line(
    folder: Path, file: str, old: str, new: str, code: str, line: int
) -> None:
    change(folder, file, old, new)
    found = [(one.code.name, one.line) for one in warnings_about(folder)]
    assert (code, line) in found


def test_a_division_by_a_rate_that_is_0_at_first_ends_the_run_with_its_line(
    folder: Path, golden: Golden
) -> None:
    line = change(folder, CODE, "0.01 * (right.rate", "1 / left.rate * (right.rate")
    with nrp_core.open_run(folder / YAML) as run, pytest.raises(NrpError) as raised:
        run.run(0.1)
    assert f"functions.py:{line}" in str(raised.value)
    golden(str(raised.value))
