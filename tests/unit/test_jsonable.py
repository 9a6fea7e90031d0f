from dataclasses import dataclass
from enum import Enum
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from nrp_core._support.json_values import to_jsonable
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.simulation import Determinism


class Model(BaseModel):
    path: Path
    kind: type = Twist


@dataclass
class Pair:
    left: Any
    right: Any


class Colour(Enum):
    RED = (1, 0)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (None, None),
        (True, True),
        (1.5, 1.5),
        (nan, None),
        (-inf, None),
        (Determinism.BITWISE, "bitwise"),
        (Colour.RED, [1, 0]),
        (frozenset({"b", "a"}), ["a", "b"]),
        ((1, [2, {3}]), [1, [2, [3]]]),
        ({1: Path("/a")}, {"1": "/a"}),
        (np.array([[1, 2]]), [[1, 2]]),
        (np.float64(nan), None),
        (np.int32(3), 3),
        (Pair(Vector3(1.0), None), {"left": {"x": 1.0, "y": 0.0, "z": 0.0}, "right": None}),
        (Model(path=Path("/a")), {"path": "/a", "kind": "geometry_msgs/msg/Twist"}),
        (complex(1, 2), "(1+2j)"),
    ],
)
def test_any_data_become_valid_json(data: Any, expected: object) -> None:
    assert to_jsonable(data) == expected
