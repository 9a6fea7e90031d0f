"""What states wait for, and the functions that they call, doubted without running the machine."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from nrp_core._support.dotted import last_name
from nrp_core.checks.code.shapes import full_names
from nrp_core.checks.code.syntax import excerpt, number_of
from nrp_core.clock import from_seconds, seconds
from nrp_core.errors import ExperimentError
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.scene.model import Scene
from nrp_legacy.code import Source
from nrp_legacy.constants import with_constants
from nrp_legacy.machine_conditions import distant_places, doubtful_conditions
from nrp_legacy.machine_slips import is_scxml
from nrp_legacy.notes import unnoted

Doubt = tuple[Code, ast.expr | ast.stmt, str]
"""The kind of a doubt, where it is, and its sentence."""

_WAITS: Final = {"WaitToClockState": ("time",), "ClockDelayState": ("waitfor", "waittime")}
"""States that wait for a time, and the names of their argument."""
_CLOCKS: Final = frozenset({
    "time.time", "time.clock", "datetime.datetime.now", "datetime.now", "datetime.datetime.today",
})  # fmt: skip
_USER_DATA: Final = ("ud", "userdata", "user_data", "_userdata", "_ud")


def doubts_of(path: Path, duration_ns: int) -> Iterator[Finding]:
    """Yield a finding for each wait, condition and function of a state machine that is probably not meant.

    Args:
        path: its file; one that cannot be read is reported by :func:`.machine_slips.slips_of`.
        duration_ns: duration of the experiment.
    """
    tree = _tree(path)
    doubts: tuple[Doubt, ...] = (
        *_waits(tree, duration_ns), *_sleeps(tree, duration_ns), *_clocks(tree), *_uncalled(tree),
        *_subscribers(tree),
        *doubtful_conditions(tree, seconds(duration_ns)),
    )  # fmt: skip
    for code, node, message in sorted(doubts, key=lambda doubt: doubt[1].lineno):
        yield Finding(code, message, Level.WARNING, path, node.lineno)


def doubts_in(scene: Scene, path: Path) -> Iterator[Finding]:
    """Yield a finding for each place in a state machine that is outside the scene of its run."""
    for node, message in distant_places(_tree(path), scene):
        yield Finding(Code.NRP248, message, Level.WARNING, path, node.lineno)


def _tree(path: Path) -> ast.Module:
    """Return a file with its constants; empty if it cannot be read, which is reported elsewhere."""
    try:
        return ast.Module([], []) if is_scxml(path) else with_constants(Source.of_file(path).tree(unnoted))
    except ExperimentError:
        return ast.Module([], [])


def _waits(tree: ast.Module, duration_ns: int) -> Iterator[Doubt]:
    """Yield the waits that end after the run, and those that end before they begin."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        kind = last_name(node.func)
        given = [*node.args[:1], *(one.value for one in node.keywords if one.arg in _WAITS.get(kind, ()))]
        match given:
            case [ast.Constant(str() as text), *_] if kind in _WAITS:
                message = (
                    f"the state waits for a text, {text!r}: the platform compared it with the time, and in "
                    "Python 2 no time reaches a text; write the number"
                )
                yield Code.NRP248, node, message
        wait_s = number_of(given[0]) if given and kind in _WAITS else None
        if wait_s is None:
            continue
        if wait_s < 0:
            yield Code.NRP248, node, f"the state waits for {wait_s:g} s, which is negative: it ends at once"
        elif from_seconds(wait_s) >= duration_ns:
            till = "until" if kind == "WaitToClockState" else "for"
            message = f"the state waits {till} {wait_s:g} s, and the run ends at {seconds(duration_ns):g} s"
            yield Code.NRP248, node, message


def _sleeps(tree: ast.Module, duration_ns: int) -> Iterator[Doubt]:
    """Yield the sleeps that end after the run."""
    for node in ast.walk(tree):
        match node:
            case ast.Call(func, [given]) if ast.unparse(func) in ("rospy.sleep", "time.sleep"):
                inner = given.args[0] if isinstance(given, ast.Call) and given.args else given
                wait_s = number_of(inner)
                if wait_s is not None and from_seconds(wait_s) >= duration_ns:
                    message = f"'{excerpt(node)}' ends after the run of {seconds(duration_ns):g} s"
                    yield Code.NRP248, node, message


def _clocks(tree: ast.Module) -> Iterator[Doubt]:
    """Yield the uses of the clock on the wall."""
    imported = full_names(tree)
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        written = ast.unparse(node.func)
        root, dot, rest = written.partition(".")
        name = imported.get(root, root) + dot + rest
        if name == "time.sleep":
            message = f"'{excerpt(node)}' waits in simulated time here, not by the clock on the wall"
            yield Code.NRP255, node, message
        elif name in _CLOCKS and root in imported:
            message = (
                f"'{written}' reads the clock on the wall, which differs between runs; "
                "rospy.get_time() is simulated time"
            )
            yield Code.NRP243, node, message


def _uncalled(tree: ast.Module) -> Iterator[Doubt]:
    """Yield callbacks and states that the file defines and never uses."""
    used = {
        one.id if isinstance(one, ast.Name) else one.attr
        for one in ast.walk(tree)
        if isinstance(one, ast.Attribute) or (isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load))
    }
    for node in tree.body:
        match node:
            case ast.FunctionDef(name) if name not in used and _is_callback(node):
                message = f"the callback '{name}' is given to no state: it is never called"
                yield Code.NRP327, node, message
            case ast.ClassDef(name, [*_, base]) if name not in used and last_name(base).endswith("State"):
                yield Code.NRP327, node, f"the state '{name}' is in no machine: it is never executed"


def _is_callback(node: ast.FunctionDef) -> bool:
    decorated = any("cb_interface" in ast.unparse(one) for one in node.decorator_list)
    return decorated or bool(node.args.args and node.args.args[0].arg in _USER_DATA)


def _subscribers(tree: ast.Module) -> Iterator[Doubt]:
    """Yield the subscribers that call nothing."""
    imported = full_names(tree)
    for node in ast.walk(tree):
        match node:
            case ast.Call(func, [topic, _], keywords) if all(one.arg != "callback" for one in keywords):
                root, dot, rest = ast.unparse(func).partition(".")
                if imported.get(root, "") + dot + rest == "rospy.Subscriber":
                    message = (
                        f"the subscriber of {ast.unparse(topic)} does not have a callback: nothing reads it"
                    )
                    yield Code.NRP327, node, message
