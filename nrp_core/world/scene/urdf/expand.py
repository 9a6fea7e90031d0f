"""Xacro, the macro language that URDF files are written in, expanded by the ``xacro`` package of ROS."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any

from nrp_core._support.xml_text import strict_xml
from nrp_core.errors import SceneError
from nrp_core.world.scene.reading.xml import Element, parse_xml, read_xml, without_lines

_SUBSTITUTION = ("$(", "${")


def is_xacro(robot: Element) -> bool:
    """Return whether a ``<robot>`` must be expanded: it has macros or substitutions."""
    return any(
        child.tag.startswith("xacro:")
        or any(mark in value for value in child.attributes.values() for mark in _SUBSTITUTION)
        or is_xacro(child)
        for child in robot.children
    )


def expanded(path: Path, package: Callable[[str], Path]) -> Element:
    """Return the expanded ``<robot>`` of a xacro file, with the defaults of its arguments.

    Lines are unknown after the expansion: all elements are in line 1.

    Args:
        path: the file.
        package: returns the folder of a package, for ``$(find ...)``.

    Raises:
        SceneError: xacro is not installed, or cannot expand the file.
    """
    try:
        import xacro
        from xacro import substitution_args
    except ImportError:
        message = (
            "this is a xacro file and xacro is not installed: pip install 'nrp-core[xacro]', "
            "or expand it with `xacro FILE > robot.urdf`"
        )
        raise SceneError(message, path=path) from None

    try:
        with (
            _finding(substitution_args, lambda name: str(package(name))),
            _checking(xacro),
            redirect_stderr(StringIO()),
        ):
            text = xacro.process_file(str(path)).toxml(encoding="utf-8")
    except (Exception, SystemExit) as error:  # noqa: BLE001  whatever Python in the file does
        reason = " ".join(str(error).split()) or type(error).__name__
        raise SceneError(f"xacro cannot expand this file: {reason}", path=path) from None
    return without_lines(parse_xml(text, path))


@contextmanager
def _checking(xacro: Any) -> Iterator[None]:
    """Check every file with our parser first, included files as well.

    Our parser refuses document types, and accepts comments that xacro's parser refuses.
    """
    own = xacro.parse

    def parse(inp: Any, filename: str | None = None) -> Any:
        if inp is None and filename is not None:
            read_xml(Path(filename))
            inp = strict_xml(Path(filename).read_bytes())
        return own(inp, filename)

    xacro.parse = parse
    try:
        yield
    finally:
        xacro.parse = own


@contextmanager
def _finding(substitution_args: Any, find: Callable[[str], str]) -> Iterator[None]:
    """Resolve ``$(find ...)`` here, because xacro needs an installation of ROS for it."""
    own, functions = substitution_args._eval_find, substitution_args._eval_dict
    substitution_args._eval_find = functions["find"] = find
    try:
        yield
    finally:
        substitution_args._eval_find = functions["find"] = own
