"""Only functions that compute are called once for all copies."""

from types import FunctionType

import pytest

from nrp_core.dsl.copies.purity import obstacle

HEAD = """
import math
import random
import numpy as np
from numpy import clip
from nrp_core.world.messages.geometry_msgs import Twist, Vector3

GAIN = 2.0
SEEN = []

def helper(x):
    return max(x, GAIN)

def remembering(x):
    SEEN.append(x)
"""


def made(body, head=HEAD):
    names = {}
    exec(head + "def function(t, a, b):\n    " + body.replace("\n", "\n    "), names)
    assert isinstance(names["function"], FunctionType)
    return names["function"]


@pytest.mark.parametrize(
    "body",
    [
        "b.rate = GAIN * np.cos(a.value).max()",
        "return Twist(Vector3(clip(a.rate, 0.0, 1.0), 0, 0), Vector3())",
        "b.send_message(helper(a.rate))",
        "if a.value is None:\n    return\nb.rate = abs(a.value.ranges.min()) ** 2",
    ],
)
def test_a_function_that_computes_may_be(body):
    assert obstacle([made(body), made(body)]) == ""


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("global GAIN\nGAIN = a.rate", "global variable"),
        ("SEEN.append(a.rate)", "append"),
        ("remembering(a.rate)", "its function 'remembering': it calls 'append'"),
        ("b.rate = random.random()", "random"),
        ("b.rate = np.random.rand()", "calls 'rand'"),
        ("a.value.data[0] = 1", "sets items"),
        ("a.value.ranges.sort()", "sort"),
        ("a.value.header.frame_id = 'x'", "frame_id"),
        ("import os", "imports"),
        ("try:\n    b.rate = a.rate\nexcept ValueError:\n    pass", "catches errors"),
        ("print(a.rate)", "print"),
        ("b.rate = len(SEEN)", "SEEN"),
        ("if a.value is t[0]:\n    b.rate = 1.0", "'is'"),
        ("if a.value is SEEN:\n    b.rate = 1.0", "'is'"),
    ],
)
def test_a_function_with_side_effects_or_state_may_not_be(body, reason):
    assert reason in obstacle([made(body), made(body)])


def test_a_function_that_differs_between_copies_may_not_be():
    other = HEAD.replace("GAIN = 2.0", "GAIN = 3.0")
    assert "'GAIN' differs" in obstacle([made("b.rate = GAIN"), made("b.rate = GAIN", other)])
    assert "it differs" in obstacle([made("b.rate = 1.0"), made("b.rate = 2.0")])
    assert "'helper'" in obstacle([made("b.rate = helper(1.0)"), made("b.rate = helper(1.0)", other)])
