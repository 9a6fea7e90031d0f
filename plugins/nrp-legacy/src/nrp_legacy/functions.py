"""The transfer functions of an experiment: Python in files or inline, and building blocks."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace

from nrp_bibi.generation.part import CodePart
from nrp_bibi.generation.transformation import transformed
from nrp_bibi.reader import model_of

from nrp_core.dsl import PythonSource, TransferFunction, load_transfer_functions
from nrp_core.errors import TransferFunctionError
from nrp_core.xml import Element
from nrp_legacy.code import Notes, Source
from nrp_legacy.documents import attribute, children, is_active, local, priority_of, text
from nrp_legacy.files import Library
from nrp_legacy.namespace import Namespace

_OF_BLOCKS = ("local", "device", "deviceGroup", "topic", "returnValue")
_PYTHON = ("PythonTransferFunction", "transferFunctionImport", "transferFunctionInline")


def load(
    element: Element, root: Element, library: Library, names: Namespace, notes: Notes
) -> list[TransferFunction]:
    """Return the transfer functions of one element.

    Args:
        element: ``<transferFunction>``, in any of its forms.
        root: the document, which holds connectors that several refer to.
        library: the search path for files.
        names: the namespace that all share.
        notes: called with a note about each conversion.

    Raises:
        ExperimentError: it does not exist, is not Python, or has no meaning.
    """
    loaded = list(
        _python(element, library, names, notes) if _is_python(element) else _blocks(element, root, names)
    )
    for function in loaded:
        function.priority = priority_of(element) or function.priority
        function.active = is_active(element) and function.active
    return loaded


def sources_of(element: Element, root: Element, library: Library, notes: Notes) -> list[PythonSource]:
    """Return the code that :func:`load` would execute.

    Raises:
        ExperimentError: it does not exist, is not Python, or has no meaning.
    """
    if not _is_python(element):
        return [part.source() for part in _parts(element, root)]
    source = _source(element, library)
    tree = source.tree(notes)
    if not is_active(element):
        names = [item.name for item in tree.body if isinstance(item, ast.FunctionDef) and item.decorator_list]
        tree.body += ast.parse("\n".join(f"{name}.active = False" for name in names)).body
    return [PythonSource(source.path, tree, has_columns=False)]


def part_source(element: Element, root: Element, library: Library) -> list[Source]:
    """Return the code of one element; for building blocks the equivalent Python.

    Raises:
        ExperimentError: it does not exist, or has no meaning.
    """
    if _is_python(element):
        return [_source(element, library)]
    return [Source(part.text, part.path) for part in _parts(element, root)]


def code_of(element: Element, library: Library) -> str:
    """Return the code of one element, in any version of Python; for building blocks the equivalent Python.

    Raises:
        ExperimentError: it does not exist.
    """
    if _is_python(element):
        return _source(element, library).text
    return "\n".join(_texts(element))


def _texts(element: Element) -> Iterator[str]:
    """Yield the names of topics in an element, as code has them."""
    for each in (element, *element.children):
        topic = attribute(each, "topic")
        if topic is not None:
            yield repr(topic)


def _is_python(element: Element) -> bool:
    kind = local(attribute(element, "type") or element.tag)
    return kind in _PYTHON or not children(element, *_OF_BLOCKS)


def _python(element: Element, library: Library, names: Namespace, notes: Notes) -> Iterator[TransferFunction]:
    source = _source(element, library)
    made = load_transfer_functions(
        source.path, module=names.module, code=source.compiled(notes), scope=names.scope
    )
    if not made:
        raise TransferFunctionError(
            "does not declare a transfer function", path=source.path, line=source.first_line
        )
    yield from made


def _source(element: Element, library: Library) -> Source:
    name = attribute(element, "src") or text(element, "src", "file") or None
    if name is None and local(element.tag) == "transferFunctionImport":
        name = element.text
    if name is None:
        return Source.of_element(element)
    path = library.find_code(name)
    if path is None:
        raise element.error(f"the experiment does not have a transfer function '{name}'")
    return Source.of_file(path)


def _blocks(element: Element, root: Element, names: Namespace) -> Iterator[TransferFunction]:
    for part in _parts(element, root):
        yield from load_transfer_functions(
            part.path, module=names.module, code=part.compiled(), scope=names.scope
        )


def _parts(element: Element, root: Element) -> list[CodePart]:
    """Return the Python equivalent of building blocks."""
    shared = children(root, "connectors", "synapseDynamics")
    alone = replace(root, children=[*shared, element], text="", raw_text="")
    return transformed(model_of(alone), element.path)[1:]
