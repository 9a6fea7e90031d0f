"""Arrays of pixels whose shape or arithmetic is not that of the image."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping

from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_function
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.findings import Code, Finding, Level

_BYTES = ("uint8", "imgmsg_to_cv2")
_WIDER = ("astype", "float", "int16", "int32", "int(")
_DIFFERENCE = "'{}' subtracts bytes, and 10 - 20 is then 246; convert one first: .astype(int)"


@checks_function(Code.NRP331)
def images_have_rows_of_columns(function: CheckedFunction) -> Iterator[Finding]:
    """Look for arrays with the width of an image before its height."""
    for node in function.declared.own:
        match node:
            case ast.Call(ast.Attribute(_, "reshape"), args):
                sizes = args[0].elts if args and isinstance(args[0], ast.Tuple | ast.List) else args
                names = [one.attr for one in sizes if isinstance(one, ast.Attribute)]
                if names[:2] == ["width", "height"]:
                    message = (
                        f"'{excerpt(node)}' mixes up the pixels: an image is stored row by row, so "
                        "its height comes first"
                    )
                    yield function.declared.finding(Code.NRP331, node, message, Level.WARNING)


@checks_function(Code.NRP331)
def colours_keep_their_order(function: CheckedFunction) -> Iterator[Finding]:
    """Look for conversions of pixels as BGR that are RGB, as those of all cameras, and vice versa."""
    orders: dict[str, str] = {}
    for node in sorted(function.declared.own, key=_end):
        match node:
            case ast.Call(ast.Attribute(_, "cvtColor"), [image, ast.Attribute(_, code), *_]):
                taken, is_, _ = code.removeprefix("COLOR_").partition("2")
                given = _order(image, orders)
                if is_ and {taken, given} == {"RGB", "BGR"}:
                    message = (
                        f"'{excerpt(node)}' takes the pixels as {taken}, and they are {given}: red "
                        f"and blue are exchanged; write COLOR_{given}2..."
                    )
                    yield function.declared.finding(Code.NRP331, node, message, Level.WARNING)
            case ast.Assign(targets, value):
                orders |= {one.id: _order(value, orders) for one in targets if isinstance(one, ast.Name)}


def _end(node: ast.AST) -> tuple[int, int, bool]:
    """Return where a piece of code ends; a statement comes after the expressions in it."""
    line, column = getattr(node, "end_lineno", 0), getattr(node, "end_col_offset", 0)
    return line, column, isinstance(node, ast.stmt)


def _order(value: ast.expr, orders: Mapping[str, str]) -> str:
    """Return the order of the colours in an image, RGB or BGR; empty if it is unknown."""
    match value:
        case ast.Name(name):
            return orders.get(name, "")
        case ast.Call(ast.Attribute(_, "imgmsg_to_cv2"), args, keywords):
            given = [*args[1:2], *(one.value for one in keywords if one.arg == "desired_encoding")]
            encoding = ast.unparse(given[0]).strip("'\"") if given else "passthrough"
            return "RGB" if encoding == "passthrough" else encoding.upper().removesuffix("8")
        case ast.Call(ast.Attribute(inner, "reshape" | "copy")):
            return _order(inner, orders)
        case ast.Call(ast.Attribute(_, "frombuffer"), [ast.Attribute(_, "data"), *_]):
            return "RGB"
    return ""


@checks_function(Code.NRP331)
def differences_of_bytes_do_not_wrap(function: CheckedFunction) -> Iterator[Finding]:
    """Look for differences of pixels that are unsigned bytes."""
    nodes = function.declared.own
    assigned = [node for node in nodes if isinstance(node, ast.Assign)]
    images: set[str] = set()
    for step in sorted(assigned, key=lambda one: one.lineno):
        text = ast.unparse(step.value)
        is_image = any(one in text for one in _BYTES) or _root(step.value) in images
        names = {one.id for one in step.targets if isinstance(one, ast.Name)}
        if is_image and not any(one in text for one in _WIDER):
            images |= names
        else:
            images -= names
    for node in nodes:
        match node:
            case ast.BinOp(left, ast.Sub(), right) if {_root(left), _root(right)} <= images:
                message = _DIFFERENCE.format(excerpt(node))
                yield function.declared.finding(Code.NRP331, node, message, Level.WARNING)


def _root(node: ast.expr) -> str:
    """Return the name of an array that an expression picks from; empty for other expressions."""
    while isinstance(node, ast.Subscript):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""
