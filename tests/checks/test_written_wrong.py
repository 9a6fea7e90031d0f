"""Mistakes of spelling and punctuation that Python takes as something else are reported at their line."""

from __future__ import annotations

from pathlib import Path

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Finding, Level

# The comment in a line is the code of its finding and some words of it.
WRONG = """\
import hbp_nrp_client.tf_frmaework as client  # NRP218 there is no module
import math
from geometry_msgs.msg import Twist, Vector3

GAIN = 2.0


def half(value):
    return value / 2.5


@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapVariable  # NRP210 must be called: @nrp.MapVariable(...)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, left, count):
    x = GAIN * min  # NRP240 'min' is a function, not a value; call it: min(...)
    x = x + 2.0 * half  # NRP240 'half' is a function, not a value; call it: half(...)
    x = x + None * left.voltage  # NRP240 None is not a number
    x = x - left.voltage / Vector3  # NRP240 'Vector3' is a class, not a value; call it: Vector3(...)
    x = x + float("nan") * left.voltage  # NRP240 always nan
    linear = Vector3(x, 0, 0)
    angular = Vector3(0, 0, math.sqrt)  # NRP240 'sqrt' is a function, not a value; call it
    if t > 2:
        return Twist(Vector3, angular)  # NRP240 'Vector3' is a class, not a value; call it
    return Twist(linear, None)  # NRP240 must be a geometry_msgs/msg/Vector3, not None
"""

RIGHT = """\
import os.path
import xml.etree.ElementTree
import hbp_nrp_client.tf_framework as client
import numpy as np
from functools import singledispatch, wraps
from geometry_msgs.msg import Twist, Vector3

GAIN = None
GAIN = 2.0
LIMIT = 1.0
LIMIT = LIMIT + 1.0
MAPPED = {"a": 1, "b": 1}
if MAPPED:
    LIMIT = 3.0
KIND = "%s %s" % (None, min)
SIDES = [(one, other) for one in ("a", "b") for other in (0, 1) if other]

try:
    from math import hypot
except ImportError:
    def hypot(x, y):
        return (x * x + y * y) ** 0.5


def kept(function):
    @wraps(function)
    def work(*given):
        return function(*given)
    return work


def drop(*given):
    return given[0]


@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapVariable("best", initial_value=float("inf"))
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
@kept
def drive(t, left, best):
    best.value = min(best.value, left.voltage)
    text = "%s" % None
    rows = sorted([left.voltage, GAIN], key=abs) + [0.0] * 2
    made = np.array(rows, dtype=float) * LIMIT
    work = abs if t > 1 else min
    made[0] += (t > 1) * LIMIT + (MAPPED is True)
    if best.value == float("inf") or text is None:
        return Twist()
    return Twist(Vector3(drop(*rows) + work(made[0], 0), 0, 0), Vector3())
"""


def found_in(path: Path, text: str) -> list[Finding]:
    (path.parent / "listing1.py").write_text(text)
    found = validate_file(path)
    return [one for one in found if one.level is not Level.NOTE and one.path == path.parent / "listing1.py"]


def test_each_is_reported_at_its_line(functions: Path) -> None:
    found = found_in(functions, WRONG)
    for number, line in enumerate(WRONG.splitlines(), start=1):
        _, _, expected = line.partition("  # ")
        here = [one for one in found if one.line == number]
        if expected:
            code, _, words = expected.partition(" ")
            assert any(one.code.name == code and words in one.message for one in here), (
                line,
                list(map(str, here)),
            )
        else:
            assert not here, line


def test_code_that_looks_alike_is_not_accused(functions: Path) -> None:
    assert [str(one) for one in found_in(functions, RIGHT)] == []


AS_MEANT = """
def wire():
    synapses = sim.Projection(circuit, circuit, sim.OneToOneConnector(), sim.StaticSynapse(delay=0.1))
wire()
pair = circuit[0:1] + circuit[1:2]
"""


def test_a_brain_script_that_looks_alike_is_not_accused(husky: Path) -> None:
    path = husky / "brain.py"
    path.write_text(path.read_text() + AS_MEANT)
    assert [str(one) for one in validate_file(husky) if one.path == path] == []
