"""Angles in degrees for joints, and comparisons that fail or never hold, are found before a run."""

from __future__ import annotations

import shutil
from pathlib import Path

import nrp_experiments
import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code, Level

SHIPPED = Path(next(iter(nrp_experiments.__path__)))
_SHOULDER = "shoulder.send_message(Float64(wanted[0] + RAD_PER_HZ * (down - up)))"
_BEGIN = "    alarms = []\n"


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The reaching arm in one place, so that its brain is looked at once."""
    folder = tmp_path_factory.mktemp("experiments")
    for name in ("bodies", "reaching_arm"):
        shutil.copytree(SHIPPED / name, folder / name)
    return folder / "reaching_arm"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("", "", None),
        (_SHOULDER, f"{_SHOULDER}\n    shoulder.send_message(Float64(1.5))", None),
        (
            _SHOULDER,
            f"{_SHOULDER}\n    shoulder.send_message(Float64(90))",
            "takes radians, and 90 is 14 turns",
        ),
        (_SHOULDER, f"{_SHOULDER}\n    elbow.send_message(-180.0)", "-180 degrees are -3.142"),
        (_BEGIN, f"{_BEGIN}    if state.position[0] == 0.0:\n        return\n", None),
        (
            _BEGIN,
            f"{_BEGIN}    if state.position == [0, 0]:\n        return\n",
            "'state.position' is an array",
        ),
        (
            _BEGIN,
            f"{_BEGIN}    if t > 1 and state.velocity > 0:\n        return\n",
            "'state.velocity' is an array",
        ),
        (_BEGIN, f"{_BEGIN}    if state.name == ['elbow']:\n        return\n", None),
        (_BEGIN, f"{_BEGIN}    if state.name == ('elbow',):\n        return\n", "it never equals a tuple"),
    ],
)
def test_commands_in_degrees_and_comparisons_that_fail_are_found(
    arm: Path, old: str, new: str, words: str | None
) -> None:
    text = (SHIPPED / "reaching_arm" / "reach.py").read_text("utf-8")
    assert old in text
    (arm / "reach.py").write_text(text.replace(old, new, 1), "utf-8")
    found = [
        str(one)
        for one in validate_file(arm / "experiment.yaml")
        if one.level is not Level.NOTE and one.code is not Code.NRP319  # a message is sent twice
    ]
    assert len(found) == (words is not None), found
    assert words is None or words in found[0]


def test_an_event_that_commands_a_joint_in_degrees_is_found(arm: Path) -> None:
    (arm / "reach.py").write_text((SHIPPED / "reaching_arm" / "reach.py").read_text("utf-8"), "utf-8")
    value = "events={go: {at: 1 s, publish: {topic: /arm/elbow/cmd_pos, value: %s}}}"
    said = ["\n".join(map(str, validate_file(arm / "experiment.yaml", [value % one]))) for one in ("90", "1")]
    assert "'/arm/elbow/cmd_pos' takes radians, and 90 is 14 turns" in said[0]
    assert "takes radians" not in said[1]
