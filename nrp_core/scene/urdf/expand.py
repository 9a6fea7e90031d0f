"""Xacro, the macro language that URDF files are written in, expanded by the ``xacro`` package of ROS."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, redirect_stderr
from functools import partial
from io import StringIO
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeGuard

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.scene.reading.context import (
    Element,
    in_sources,
    no_package,
    parse_xml,
    read_xml,
    without_lines,
)
from nrp_core.xml import strict_xml

_PACKAGE = "package://"
_SUBSTITUTION = ("$(", "${")
_ARGUMENT = re.compile(r"\$\(arg (\w+)\)")
_WITHOUT_VALUE = re.compile(r"Undefined substitution argument (\w+)")
_MAX_POWER_BITS = 10_000
_CLASS = re.compile(r"<class '[\w.]+'>: ")
"""How xacro writes the class of an error that a substitution raises."""


def is_xacro(robot: Element) -> bool:
    """Return whether a ``<robot>`` must be expanded: it has macros or substitutions."""
    return any(
        child.tag.startswith("xacro:")
        or any(mark in value for value in (*child.attributes.values(), child.text) for mark in _SUBSTITUTION)
        or is_xacro(child)
        for child in robot.children
    )


def expand_xacro(
    path: Path,
    package: Callable[[str], Path],
    args: Mapping[str, object] = MappingProxyType({}),
    leave_out: Callable[[str], None] | None = None,
) -> Element:
    """Return the expanded ``<robot>`` of a xacro file.

    Lines are unknown after the expansion: all elements are in line 1. ``$(find name)`` of a package that is
    not here is ``package://name``, so that only what needs its files fails.

    Args:
        path: the file.
        package: returns the folder of a package, for ``$(find ...)``.
        args: values of its arguments; others have their defaults.
        leave_out: receives messages about included files of missing packages, and their macros, which are
            left out; None: they are errors.

    Raises:
        SceneError: xacro is not installed, or cannot expand the file, or the file declares no such argument.
    """
    try:
        import xacro
        from xacro import substitution_args
    except ImportError:
        message = (
            "this is a xacro file and xacro is not installed: pip install 'nrp-core[models]', "
            "or expand it with `xacro FILE > robot.urdf`"
        )
        raise SceneError(message, path=path) from None

    declared: set[str] = set()
    find = partial(_folder_of, package)
    functions = {
        "parse": _checked_parse(xacro.parse, declared),
        "safe_eval": _bounded_eval(xacro.safe_eval),
        **_without_missing(xacro, leave_out),
    }
    try:
        # `$(find ...)` is resolved here, because xacro needs an installation of ROS for it
        with (
            _patched(vars(substitution_args), _eval_find=find),
            _patched(substitution_args._eval_dict, find=find),
            _patched(vars(xacro), **functions),
            redirect_stderr(StringIO()),
        ):
            given = {**_early(path), **{name: _as_text(value) for name, value in args.items()}}
            text = xacro.process_file(str(path), mappings=given).toxml(encoding="utf-8")
    except (Exception, SystemExit) as error:  # noqa: BLE001  whatever Python in the file does
        reason = " ".join(str(error).split()) or type(error).__name__
        reason = _once(_CLASS.sub("", reason).removeprefix(f"{path}: "), path)
        if "maximum recursion depth" in reason:
            reason = "it includes itself, or one of its macros calls itself without an end"
        reason = _WITHOUT_VALUE.sub(_asking_for, reason)
        raise SceneError(f"xacro cannot expand this file: {reason}", path=path) from None
    for name in args:
        if name not in declared:
            raise SceneError(f"this file has no argument '{name}'{did_you_mean(name, declared)}", path=path)
    return without_lines(parse_xml(text, path))


def _folder_of(package: Callable[[str], Path], name: str) -> str:
    try:
        return str(package(name))
    except SceneError:
        return f"{_PACKAGE}{name}"


@contextmanager
def _patched(names: dict[str, Any], **functions: Any) -> Iterator[None]:
    """Replace functions in the names of a module."""
    own = {name: names[name] for name in functions}
    names.update(functions)
    try:
        yield
    finally:
        names.update(own)


def _without_missing(xacro: Any, leave_out: Callable[[str], None] | None) -> dict[str, Any]:
    """Return functions that report files of missing packages, and leave out these and the macros in them."""
    include, call = xacro.get_include_files, xacro.handle_macro_call
    missing: list[str] = []

    def included(spec: str, symbols: Any) -> Iterator[str]:
        for file in include(spec, symbols):
            _, is_missing, rest = file.partition(_PACKAGE)
            if not is_missing:
                place = Path(file)
                yield file if place.exists() else str(in_sources(place) or file)
                continue
            missing.append(rest.partition("/")[0])
            message = no_package(missing[-1])
            if leave_out is None:
                raise SceneError(message)
            leave_out(f"{message}: its '{rest.partition('/')[2]}' is left out")

    def called(node: Any, macros: Any, symbols: Any) -> Any:
        try:
            return call(node, macros, symbols)
        except xacro.XacroException as error:
            if leave_out is None or not missing or str(error) != f"unknown macro name: {node.tagName}":
                raise
            leave_out(f"<{node.tagName}> is left out: its macro may be in the package '{missing[-1]}'")
            xacro.replace_node(node, by=None)
            return True

    return {"get_include_files": included, "handle_macro_call": called}


def _early(path: Path) -> dict[str, str]:
    """Return the defaults of the arguments in the attributes of ``<robot>``, which xacro needs before it."""
    robot = read_xml(path)
    needed = {name for value in robot.attributes.values() for name in _ARGUMENT.findall(value)}
    defaults = {arg.attribute("name"): arg.attributes.get("default") for arg in robot.all("xacro:arg")}
    return {
        name: default
        for name in sorted(needed)
        if (default := defaults.get(name)) is not None and not any(mark in default for mark in _SUBSTITUTION)
    }


def _once(reason: str, path: Path) -> str:
    """Return what xacro says of an error in a substitution, which it says twice."""
    twice = re.fullmatch(rf"(.+) (?:{re.escape(str(path))}: )?\1", reason)
    return reason if twice is None else twice[1]


def _asking_for(missing: re.Match[str]) -> str:
    name = missing[1]
    return (
        f"its argument '{name}' has no default; give it a value: args: {{{name}: VALUE}} of the robot in an "
        f"experiment, or -s args.{name}=VALUE to nrp inspect"
    )


def _as_text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _arguments(element: Element) -> Iterator[str]:
    """Yield the arguments that a file declares."""
    if element.tag == "xacro:arg":
        yield element.attribute("name")
    for child in element.children:
        yield from _arguments(child)


def _checked_parse(own: Callable[..., Any], declared: set[str]) -> Callable[..., Any]:
    """Return a parser that checks files with ours first, included ones as well, and collects the arguments.

    Our parser refuses document types, and accepts comments that xacro's parser refuses.
    """

    def parse(inp: Any, filename: str | None = None) -> Any:
        if inp is None and filename is not None:
            declared.update(_arguments(read_xml(Path(filename))))
            inp = strict_xml(Path(filename).read_bytes())
        return own(inp, filename)

    return parse


def _bounded_eval(own: Callable[..., Any]) -> Callable[..., Any]:
    """Return an evaluation that refuses powers of whole numbers that would take minutes or all memory."""

    def evaluate(expression: str, names: Any, more: Any = None) -> Any:
        powers = [node for node in ast.walk(_tree(expression)) if _is_power(node)]
        for power in reversed(powers):  # the inner ones come last
            base, exponent = (own(ast.unparse(side), names, more) for side in (power.left, power.right))
            are_whole = isinstance(base, int) and isinstance(exponent, int)
            if are_whole and base.bit_length() * exponent > _MAX_POWER_BITS:
                raise SceneError(f"the power '{ast.unparse(power)}' has more than {_MAX_POWER_BITS} bits")
        return own(expression, names, more)

    return evaluate


def _tree(expression: str) -> ast.AST:
    try:
        return ast.parse(expression.strip(), mode="eval")
    except SyntaxError:
        return ast.Pass()  # xacro reports it


def _is_power(node: ast.AST) -> TypeGuard[ast.BinOp]:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)
