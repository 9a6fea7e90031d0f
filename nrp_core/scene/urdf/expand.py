"""Xacro, the macro language that URDF files are written in, expanded by the ``xacro`` package of ROS."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, redirect_stderr
from functools import partial
from importlib import import_module
from io import StringIO
from pathlib import Path
from types import MappingProxyType
from typing import Any
from xml.dom import minidom

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.scene.reading.context import (
    Element,
    in_sources,
    no_package,
    parse_xml,
    read_xml,
    without_lines,
)
from nrp_core.scene.urdf.expressions import Budget, Evaluator
from nrp_core.xml import strict_xml

_PACKAGE = "package://"
_SUBSTITUTION = ("$(", "${")
_ARGUMENT = re.compile(r"\$\(arg (\w+)\)")
_WITHOUT_VALUE = re.compile(r"Undefined substitution argument (\w+)")
_KEYWORDS = frozenset(
    f"xacro:{name}"
    for name in (
        "arg",
        "attribute",
        "call",
        "element",
        "if",
        "include",
        "insert_block",
        "macro",
        "property",
        "unless",
    )
)
_YAML_BYTES = 1_000_000
_GLOB = re.compile(r"[^/]*[*?\[][^/]*")
_MOST_GLOBS = 2
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


def drop_unknown_calls(robot: Element) -> list[Element]:
    """Remove calls of macros from a file that neither has nor includes macros, and return them.

    Some versions of xacro leave calls of unknown macros in the URDF that they write.
    """
    holders = [*_descendants(robot)]
    macros = [
        (holder, each) for holder in holders for each in holder.children if each.tag.startswith("xacro:")
    ]
    if any(each.tag in _KEYWORDS for _, each in macros):
        return []
    for holder, call in macros:
        holder.children.remove(call)
    return [call for _, call in macros]


def _descendants(element: Element) -> Iterator[Element]:
    yield element
    for child in element.children:
        yield from _descendants(child)


def expand_xacro(
    path: Path,
    package: Callable[[str], Path],
    args: Mapping[str, object] = MappingProxyType({}),
    leave_out: Callable[[str], None] | None = None,
) -> Element:
    """Return the expanded ``<robot>`` of a xacro file.

    Lines are unknown after the expansion: all elements are in line 1. ``$(find name)`` of a package that is
    not here is ``package://name``, so that only what needs its files fails. Expressions are evaluated by
    :mod:`nrp_core.scene.urdf.expressions`, never by Python.

    Args:
        path: the file.
        package: returns the folder of a package, for ``$(find ...)``.
        args: values of its arguments; others have their defaults.
        leave_out: receives messages about included files of missing packages, and their macros, which are
            omitted; None: they are errors.

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
    find, budget = partial(_folder_of, package), Budget()
    names = _names_of_eval(xacro, substitution_args, find)
    evaluator = _evaluator(xacro, budget, names)
    functions = {
        "parse": _checked_parse(xacro.parse, declared, budget),
        "safe_eval": lambda expression, names, _=None: evaluator.evaluate(expression, names),
        "eval_all": _counted(xacro.eval_all, budget.element),
        **_without_missing(xacro, leave_out),
    }
    resolve = {"_eval_find": find, "_eval": _eval(evaluator, substitution_args.convert_value, names)}
    copy = _counted(vars(minidom)["_clone_node"], budget.copy)
    try:
        # `$(find ...)` is resolved here, because xacro needs an installation of ROS for it
        with (
            _patched(vars(substitution_args), **resolve),
            _patched(vars(minidom), _clone_node=copy),
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
        if len(_GLOB.findall(str(xacro.eval_text(spec, symbols)))) > _MOST_GLOBS:
            raise SceneError(f"'{spec}' has a wildcard in more than {_MOST_GLOBS} folders")
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
    """Return xacro's message on an error in a substitution, which it repeats."""
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


def _checked_parse(own: Callable[..., Any], declared: set[str], budget: Budget) -> Callable[..., Any]:
    """Return a parser that checks files with ours first, included ones as well, and collects the arguments.

    Our parser refuses document types, and accepts comments that xacro's parser refuses.
    """

    def parse(inp: Any, filename: str | None = None) -> Any:
        if inp is None and filename is not None:
            declared.update(_arguments(read_xml(Path(filename))))
            inp = strict_xml(Path(filename).read_bytes())
            budget.spend(len(inp))
        return own(inp, filename)

    return parse


def _evaluator(xacro: Any, budget: Budget, others: Mapping[str, Any]) -> Evaluator:
    """Return the evaluator of a file, with the functions of xacro and some others."""
    spaces = [space for space in xacro._global_symbols.values() if isinstance(space, xacro.NameSpace)]
    functions = [pair for names in (xacro._global_symbols, *spaces, others) for pair in names.items()]
    own = [(name, value) for name, value in functions if callable(value) and not name.startswith("_")]
    return Evaluator(own, budget, {"load_yaml": partial(_load_yaml, xacro, budget)})


def _names_of_eval(xacro: Any, substitution_args: Any, find: Callable[[str], str]) -> dict[str, Any]:
    """Return the names in ``$(eval ...)`` that are not arguments."""
    context = xacro.substitution_args_context

    def arg(name: str) -> Any:
        return substitution_args.convert_value(substitution_args._eval_arg(name, context["arg"]), "auto")

    def dirname() -> Any:
        return substitution_args._eval_dirname(context["filename"])

    names = {**xacro._global_symbols["python"], **substitution_args._eval_dict}
    return {**names, "arg": arg, "dirname": dirname, "find": find}


def _eval(
    evaluator: Evaluator, typed: Callable[[str, str], Any], names: Mapping[str, Any]
) -> Callable[[str, dict[str, Any]], str]:
    """Return the function that evaluates ``$(eval ...)``."""

    def evaluate(expression: str, context: dict[str, Any]) -> str:
        arguments = {name: typed(text, "auto") for name, text in context.get("arg", {}).items()}
        return str(evaluator.evaluate(expression, {**arguments, **names}))

    return evaluate


def _counted(own: Callable[..., Any], count: Callable[[], None]) -> Callable[..., Any]:
    """Return a function that counts its calls."""

    def counted(*arguments: Any) -> Any:
        count()
        return own(*arguments)

    return counted


def _load_yaml(xacro: Any, budget: Budget, filename: str) -> Any:
    """Return the values in a YAML file beside the current one, with xacro's units."""
    yaml: Any = import_module("yaml")

    def flatten(loader: Any, node: Any) -> None:
        yaml.SafeLoader.flatten_mapping(loader, node)
        budget.spend(len(node.value))

    loader: Any = type("Loader", (yaml.SafeLoader,), {"flatten_mapping": flatten})
    for unit in xacro.ConstructUnits:
        loader.add_constructor(unit.value.tag, unit.constructor)
    path = Path(xacro.abs_filename_spec(filename))
    if path.exists() and not (path.is_file() and path.stat().st_size <= _YAML_BYTES):
        raise SceneError(f"{path} is not a file of at most {_YAML_BYTES // 10**6} MB")
    return xacro.YamlListWrapper.wrap(yaml.load(path.read_text("utf-8"), loader))
