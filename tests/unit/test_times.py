"""Times are compared as whole nanoseconds.

A time that is written, ``0.3``, and one that is computed, ``3 * 0.1``, differ in their last bits. If two such
floats are compared, an event is lost, or awaited for ever.
"""

from __future__ import annotations

import ast
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CORE = ("network", "brain", "pynn", "cle", "dsl", "world", "experiment", "checks")
PLUGINS = ("legacy", "ebrains", "spynnaker", "pynest", "nestml")
FOLDERS = (
    *(ROOT / "nrp_core" / part for part in CORE),
    *(ROOT / "backends").glob("*/*/"),
    *(ROOT / "plugins").glob("nrp-brain-*/src"),
    *(ROOT / "plugins" / f"nrp-{name}" / "src" for name in PLUGINS),
)

ALLOWED = {
    # Spikes are at any time, to the last bit of a float: solvers compute them, and none is at a written time.
    "backends/brain/nrp_brain_event/brain.py": 3,
    "backends/brain/nrp_brain_event/rewards.py": 1,
    "nrp_core/brain/devices/membrane_kernel.py": 3,
    "nrp_core/brain/devices/sinks.py": 2,
    "nrp_core/brain/devices/source_cells.py": 5,
    "nrp_core/brain/devices/sources.py": 1,
    "nrp_core/brain/devices/train_kernel.py": 2,
    # ranges of keys
    "plugins/nrp-spynnaker/src/nrp_spynnaker/live/packets.py": 1,
}
"""How many comparisons of floats each file has."""

_TIMES = frozenset({"start", "stop", "begin", "duration", "times", "spike_times"})
_OF_ARGUMENTS = frozenset({"min", "max", "float", "abs", "sorted"})
_OF_OBJECTS = frozenset({"item", "min", "max", "tolist", "astype", "copy"})


def last_name(node: ast.expr) -> str:
    return node.id if isinstance(node, ast.Name) else getattr(node, "attr", "")


def is_float_time(node: ast.expr) -> bool:
    """Return whether an expression is a time as a float, by its names."""
    match node:
        case ast.Subscript(value) | ast.UnaryOp(_, value) | ast.Starred(value):
            return is_float_time(value)
        case ast.BinOp(left, _, right):
            return is_float_time(left) or is_float_time(right)
        case ast.Call(ast.Attribute(value, name)) if name in _OF_OBJECTS and is_float_time(value):
            return True
        case ast.Call(function, arguments) if last_name(function) in _OF_ARGUMENTS:
            return any(map(is_float_time, arguments))
        case ast.Call(function):
            name = last_name(function)
            return name in ("milliseconds", "seconds") or (name.islower() and name.endswith(("_ms", "_s")))
        case ast.Attribute(_, name) if name in _TIMES:
            return True
        case ast.Name() | ast.Attribute():
            name = last_name(node)
            return not name.isupper() and name.endswith(("_ms", "_s"))
    return False


def float_comparisons(tree: ast.AST) -> list[int]:
    """Return the lines at which two such times are compared or searched for one another."""
    lines = []
    for node in ast.walk(tree):
        parts: list[ast.expr] = []
        match node:
            case ast.Compare(first, _, others):
                parts = [first, *others]
            case ast.Call(ast.Attribute(owner, "searchsorted"), arguments):
                parts = [owner, *arguments]
        if sum(map(is_float_time, parts)) > 1:
            lines.append(parts[0].lineno)
    return lines


def test_no_time_in_floating_point_is_compared_with_another() -> None:
    found: Counter[str] = Counter()
    places = []
    for path in (path for folder in FOLDERS for path in sorted(folder.rglob("*.py"))):
        name, lines = str(path.relative_to(ROOT)), float_comparisons(ast.parse(path.read_text()))
        found[name] += len(lines)
        if len(lines) > ALLOWED.get(name, 0):
            places += [f"{name}:{line}" for line in lines]
    assert not places, "compare nrp_core.clock.nanoseconds(...) of both times"
    assert {name: n for name, n in found.items() if n} == ALLOWED


@pytest.mark.parametrize(
    "text",
    ["source.start <= now_ms", "np.searchsorted(source.times, t_ms)", "seconds(now_ns) >= end_s",
     "min(halts_ms) < milliseconds(t_ns)", "self.times_ms[-1] == spec.stop", "spec.begin + dt_ms > until_ms"],
)  # fmt: skip
def test_a_comparison_of_floats_is_found(text: str) -> None:
    assert float_comparisons(ast.parse(text)) == [1]


@pytest.mark.parametrize(
    "text", ["start_ns <= now_ns", "delay_ms < 0.0", "t_ms > LONGEST_MS", "nanoseconds(spec.stop) > now_ns"]
)
def test_other_comparisons_are_not(text: str) -> None:
    assert float_comparisons(ast.parse(text)) == []
