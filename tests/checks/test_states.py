"""States are asked for as they are set, groups have different neurons, and shared variables are shared."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Level

HEAD = """\
import hbp_nrp_client.tf_framework as nrp
from geometry_msgs.msg import Twist

DONE = "done"


def cells(population, n):
    return lambda i: population[{index}]


@nrp.MapVariable("state", initial_value="go"{scope})
@nrp.MapSpikeSource("eyes", nrp.map_neurons(2, cells(nrp.brain.sensors, 2)), nrp.poisson)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, state, eyes):
    command = Twist()
    eyes.rate = 10.0 * t
    if t > 2:
        state.value = "turning" if t < 9 else DONE
"""


def said(husky: Path, body: str, index: str = "i", scope: str = "") -> list[str]:
    lines = "".join(f"    {line}\n" for line in [*body.splitlines(), "return command"])
    (husky / "states.py").write_text(HEAD.format(index=index, scope=scope) + lines)
    found = validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky}/states.py]"])
    return [one.message for one in found if one.level is Level.WARNING]


@pytest.mark.parametrize(
    ("test", "words"),
    [
        (
            "state.value == 'turnig'",
            "is never true: 'state.value' is only 'done' or 'go' or 'turning'; did you",
        ),
        ("state.value != 'stop'", "is always true"),
        ("state.value in ('tuning', 'stop')", "is never true"),
    ],
)
@pytest.mark.parametrize("scope", ["", ", scope=nrp.GLOBAL"])
def test_a_state_that_nothing_sets_is_found_where_it_is_asked_for(
    husky: Path, test: str, words: str, scope: str
) -> None:
    (message,) = said(husky, f"if {test}:\n    command.linear.x = 1.0", scope=scope)
    assert words in message


@pytest.mark.parametrize(
    "body",
    [
        "if state.value == 'turning':\n    command.linear.x = 1.0",
        "if state.value == DONE or state.value == 'go':\n    command.linear.x = 1.0",
        "if state.value in ('stop', 'go'):\n    command.linear.x = 1.0",
        "if state.value in 'goes on':\n    command.linear.x = 1.0",
        "state.value = str(t)\nif state.value == 'stop':\n    command.linear.x = 1.0",
        "vars(state)\nif state.value == 'stop':\n    command.linear.x = 1.0",
    ],
)
def test_states_that_are_set_or_unknown_are_right(husky: Path, body: str) -> None:
    assert said(husky, body) == []


@pytest.mark.parametrize(
    ("index", "is_same"), [("n", True), ("slice(n)", True), ("i", False), ("i % n", False)]
)
def test_a_group_whose_devices_have_the_same_neurons_is_found(
    husky: Path, index: str, *, is_same: bool
) -> None:
    found = [one for one in said(husky, "", index) if "all 2 devices of 'eyes' have the same neurons" in one]
    assert bool(found) == is_same


ALONE = """\
import hbp_nrp_client.tf_framework as nrp
from geometry_msgs.msg import Twist, Vector3


@nrp.MapVariable("near", initial_value=9.0, scope=nrp.GLOBAL)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", Twist))
def drive(t, near):
    return Twist(Vector3(0.1 * near.value))
"""
OTHER = """
@nrp.MapVariable("near", initial_value=9.0, scope=nrp.GLOBAL)
@nrp.Robot2Neuron()
def look(t, near):
    {what}
"""


@pytest.mark.parametrize(
    ("other", "is_found"),
    [
        ("", True),
        (OTHER.format(what="near.value = t"), False),
        (OTHER.format(what="print(near.value)"), False),
        (OTHER.format(what="print(near.value)").replace("initial_value=9.0, ", ""), False),
    ],
    ids=["alone", "set", "shared", "shared by one without an initial value"],
)
def test_a_shared_variable_of_one_function_that_nothing_sets_is_found(
    husky: Path, other: str, *, is_found: bool
) -> None:
    (husky / "alone.py").write_text(ALONE + other)
    found = validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky}/alone.py]"])
    words = "nothing sets the shared variable 'near', and no other function has it"
    assert any(words in one.message for one in found) == is_found
