"""Conditions and waves of the time alone, tried at the steps of the experiment."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Final

from nrp_core.checks.function_body import assigned
from nrp_core.checks.imported import full_names
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Known
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.clock import seconds
from nrp_core.findings import Code, Finding, Level

_MOST_STEPS: Final = 200_000
"""Longer experiments are not tried: it would take more than a fraction of a second."""
_FUNCTIONS: Final[Mapping[str, Any]] = {
    one.__name__: one for one in (int, float, round, abs, min, max, divmod, bool)
} | {
    f"{module}.{name}": getattr(math, name)
    for module in ("math", "numpy")
    for name in ("floor", "ceil", "fmod", "sin", "cos", "isclose", "trunc", "pi", "tau", "radians")
}
_WAVES: Final = ("sin", "cos", "math.sin", "math.cos", "np.sin", "np.cos", "numpy.sin", "numpy.cos")
_PARTS: Final = (
    ast.Compare, ast.BoolOp, ast.BinOp, ast.UnaryOp, ast.Constant, ast.Name, ast.Call, ast.Attribute,
    ast.operator, ast.unaryop, ast.cmpop, ast.boolop, ast.expr_context,
)  # fmt: skip


@checks_function(Code.NRP248)
def moments_come(function: CheckedFunction) -> Iterator[Finding]:
    """Look for conditions of ``t`` alone that no step of the experiment meets."""
    experiment, declared = function.experiment, function.declared
    steps = experiment.duration // experiment.timestep
    if steps > _MOST_STEPS or "t" in assigned(declared.node.body):
        return
    names = _numbers(function)
    for node in declared.own:
        if not isinstance(node, ast.Compare) or _is_plain(node) or not _is_of_time(node, names):
            continue
        first = 0 if experiment.tf_time == "start" else 1
        times_s = (seconds(experiment.timestep * step) for step in range(first, first + steps))
        if not _is_ever_true(node, names, times_s):
            message = (
                f"'{ast.unparse(node)}' is true at none of the {steps} steps of "
                f"{seconds(experiment.timestep):g} s"
            )
            yield declared.finding(Code.NRP248, node, message, Level.WARNING)


@checks_function(Code.NRP320)
def remainders_are_compared(function: CheckedFunction) -> Iterator[Finding]:
    """Look for remainders of ``t`` in place of conditions: they are true unless they are exactly 0."""
    if "t" in assigned(function.declared.node.body):
        return
    for node in function.declared.own:
        if not isinstance(node, ast.If | ast.IfExp | ast.While):
            continue
        for test in node.test.values if isinstance(node.test, ast.BoolOp) else [node.test]:
            tested = test.operand if isinstance(test, ast.UnaryOp) else test
            match tested:
                case ast.BinOp(ast.Name("t"), ast.Mod(), ast.Constant()):
                    message = (
                        f"'{ast.unparse(test)}' asks whether a remainder of seconds is exactly 0, and not "
                        "for a part of each period; compare it, as in t % 2 < 1"
                    )
                    yield function.declared.finding(Code.NRP320, test, message, Level.WARNING)


@checks_function(Code.NRP249)
def waves_are_slower_than_steps(function: CheckedFunction) -> Iterator[Finding]:
    """Look for sines of ``t`` that turn half a round or more from one step to the next."""
    declared, step_s = function.declared, seconds(function.experiment.timestep)
    if "t" in assigned(declared.node.body):
        return
    names = _numbers(function)
    for node in declared.own:
        match node:
            case ast.Call(func, [angle], []) if ast.unparse(func) in _WAVES and _is_of_time(angle, names):
                turns_rad = [_value(angle, names, step_s * step) for step in range(3)]
                if None in turns_rad:
                    continue
                first, second, third = turns_rad
                if abs(second - first) >= math.pi and math.isclose(third - second, second - first):
                    message = (
                        f"'{excerpt(node)}' turns by {abs(second - first):.3g} rad in a step of "
                        f"{step_s:g} s; degrees are math.radians(...), and 't' is in s"
                    )
                    yield declared.finding(Code.NRP249, node, message, Level.WARNING)


def _numbers(function: CheckedFunction) -> dict[str, Any]:
    """Return the functions and numbers that a condition may use, by name; a dotted name is one."""
    declared = function.declared
    changed = {
        name for node in ast.walk(declared.source.tree) if isinstance(node, ast.Global) for name in node.names
    }
    own = assigned(declared.node.body) | function.adapters.keys() | changed
    imported = full_names(declared.source.tree)
    found = {name: work for name, work in _FUNCTIONS.items() if "." not in name}
    for name, full in imported.items():
        found |= {
            name + dotted[len(full) :]: work
            for dotted, work in _FUNCTIONS.items()
            if f"{dotted}.".startswith(f"{full}.")
        }
    for name, shape in declared.names.items():
        match shape:
            case Known(int() | float() as value):
                found[name] = value
    return {name: value for name, value in found.items() if name.partition(".")[0] not in own}


def _is_plain(node: ast.Compare) -> bool:
    """Return whether other checks know more: ``t > 3``, ``t % 3 == 0``."""
    match node:
        case ast.Compare(ast.Name("t"), _, [_]) | ast.Compare(_, _, [ast.Name("t")]):
            return True
        case ast.Compare(ast.BinOp(ast.Name("t"), ast.Mod()), [ast.Eq()], [ast.Constant(0)]):
            return True
    return False


def _is_of_time(node: ast.expr, names: Mapping[str, Any]) -> bool:
    """Return whether a condition is of the time and numbers alone, and quick to evaluate."""
    roots = [ast.unparse(one) for one in ast.walk(node) if isinstance(one, (ast.Name, ast.Attribute))]
    inner = [ast.unparse(one.value) for one in ast.walk(node) if isinstance(one, ast.Attribute)]
    return (
        "t" in roots
        and all(name == "t" or name in names or name in inner for name in roots)
        and all(
            isinstance(one, _PARTS) and not isinstance(one, ast.Pow | ast.LShift) for one in ast.walk(node)
        )
        and not any(isinstance(one, ast.Call) and one.keywords for one in ast.walk(node))
    )


class _Flat(ast.NodeTransformer):
    """Replaces dotted names by names."""

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        return ast.Name(_flat(ast.unparse(node)), ast.Load())


def _flat(name: str) -> str:
    return name.replace(".", "__")


def _is_ever_true(node: ast.Compare, names: Mapping[str, Any], times_s: Iterable[float]) -> bool:
    """Return whether a condition is true at one of some times, or cannot be evaluated."""
    value = _compiled(node, names)
    try:
        return any(value(t_s) for t_s in times_s)
    except Exception:  # noqa: BLE001  the function would raise it, too; other checks look for that
        return True


def _value(node: ast.expr, names: Mapping[str, Any], t_s: float) -> Any:
    """Return an expression's value at a time; None if it cannot be evaluated."""
    try:
        return float(_compiled(node, names)(t_s))
    except Exception:  # noqa: BLE001  the function would raise it, too
        return None


def _compiled(node: ast.expr, names: Mapping[str, Any]) -> Callable[[float], Any]:
    """Return an expression as a function of the time."""
    flat: ast.Expression = _Flat().visit(ast.parse(ast.unparse(node), mode="eval"))
    code = compile(ast.fix_missing_locations(flat), "<expression>", "eval")
    scope: dict[str, Any] = {"__builtins__": {}}
    scope |= {_flat(name): value for name, value in names.items()}
    return lambda t_s: eval(code, scope, {"t": t_s})
