"""Generate Python transfer functions from a model."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from nrp_bibi.generation.checks import Checker
from nrp_bibi.generation.expressions import as_python, literal
from nrp_bibi.generation.imports import imports
from nrp_bibi.generation.part import CodePart
from nrp_bibi.generation.selectors import selection
from nrp_bibi.generation.settings import settings, timing
from nrp_bibi.generation.walk import bodies, channels
from nrp_bibi.model.channels import AnyDevice, TopicChannel
from nrp_bibi.model.functions import (
    Bibi,
    BIBITransferFunction,
    Neuron2Monitor,
    PythonTransferFunction,
    TransferFunction,
)
from nrp_bibi.templates import environment
from nrp_core._support.text import Misfit, decoded_python
from nrp_core.errors import did_you_mean

_MARK = "\x1f"


def generate(model: Bibi, path: Path, *, with_imports: bool = True) -> str:
    """Return the Python file generated from a model.

    Args:
        model: the model.
        path: the model's file; files of Python transfer functions are searched for beside it.
        with_imports: whether it begins with import statements; transfer functions also run without them.

    Raises:
        TransferFunctionError: the model is not valid, or names a file that does not exist.
    """
    parts = transformed(model, path)
    return "\n\n\n".join(part.text for part in (parts if with_imports else parts[1:])) + "\n"


def transformed(model: Bibi, path: Path) -> list[CodePart]:
    """Return the imports of a model and the Python of each transfer function, in order.

    Raises:
        TransferFunctionError: as for :func:`generate`.
    """
    return list(Transformation(model, path).parts())


class Transformation:
    """The transformation of one model to Python.

    Args:
        model: the model.
        path: the model's file.
    """

    def __init__(self, model: Bibi, path: Path) -> None:
        self._model, self._path = model, path
        self._checker = Checker(path)
        self._checker.check(model)

    def parts(self) -> Iterator[CodePart]:
        """Yield the parts of the code, in the order of the model."""
        needed = imports(self._model)
        yield CodePart("\n".join(needed), self._path, tuple(needed.values()))
        for function in self._model.transfer_function:
            if isinstance(function, BIBITransferFunction):
                yield self._blocks(function)
            elif isinstance(function, PythonTransferFunction):
                yield self._python(function)

    # -- building blocks

    def _blocks(self, function: BIBITransferFunction) -> CodePart:
        template = environment().get_template("transfer_function.py.j2")
        text = template.render(
            **self._channels(function),
            tf=function,
            kind=type(function).__name__,
            origin=f"{self._path.name}:{function.line}" if function.line else self._path.name,
            at=lambda node: f"{_MARK}{node.line}",
            python=lambda expression: ast.unparse(as_python(expression)),
            quoted=literal,
            selection=selection,
            timing=timing,
            settings=lambda device: settings(device, self._model, self._checker.refuse),
        )
        priority = function.priority if isinstance(function, Neuron2Monitor) else 0
        text = text.rstrip("\n") + _settled(function, [function.name], priority)
        return _marked(text, self._path, function.line)

    def _channels(self, function: BIBITransferFunction) -> dict[str, Any]:
        """Return the template variables for the channels."""
        monitor = function.device if isinstance(function, Neuron2Monitor) else None
        mapped = [] if monitor else channels(function)
        returned = getattr(function, "return_value", None)
        return {
            "topics": [channel for channel in mapped if isinstance(channel, TopicChannel)],
            "devices": [channel for channel in mapped if isinstance(channel, AnyDevice)],
            "parameters": [channel.name for channel in mapped],
            "monitor": monitor,
            "returned": returned if isinstance(returned, TopicChannel) else None,
            "is_empty": not function.local and not any(bodies(function)),
        }

    # -- Python

    def _python(self, function: PythonTransferFunction) -> CodePart:
        if function.src is None:
            path, code, first = self._path, function.code, function.code_line
        else:
            path, first = self._source(function, function.src), 1
            code = self._read(function, path)
        lines = [*range(first, first + code.count("\n") + 1)]
        settled = _settled(function, _declared(code), function.priority)
        return CodePart(code + settled, path, (*lines, *[first] * settled.count("\n")))

    def _read(self, function: PythonTransferFunction, path: Path) -> str:
        text = decoded_python(path.read_bytes())
        if isinstance(text, Misfit):
            raise self._checker.refuse(function, f"{path}:{text.line}:{text.column}: {text.message}")
        return text.rstrip()

    def _source(self, function: PythonTransferFunction, name: str) -> Path:
        """Return a file beside the model, or beside the model's folder, as in legacy experiments."""
        for folder in (self._path.parent, self._path.parent.parent):
            if (folder / name).is_file():
                return folder / name
        beside = [found.name for found in self._path.parent.glob("*.py")]
        hint = did_you_mean(name, beside) if beside else ""
        raise self._checker.refuse(function, f"no file '{name}' in {self._path.parent}{hint}")


def _marked(text: str, path: Path, first: int) -> CodePart:
    """Return the code without the marks, and the source line of each line."""
    lines = [line.partition(_MARK) for line in text.rstrip("\n").split("\n")]
    return CodePart(
        "\n".join(code for code, _, _ in lines), path, tuple(int(mark or first) for *_, mark in lines)
    )


def _settled(function: TransferFunction, names: list[str], priority: int = 0) -> str:
    """Return the statements that set the settings of functions that a decorator does not hold."""
    stated = [f"{name}.priority = {priority}" for name in names if priority]
    stated += [f"{name}.active = False" for name in names if not function.active]
    return "\n\n\n" + "\n".join(stated) if stated else ""


def _declared(code: str) -> list[str]:
    """Return the names of the transfer functions in a piece of Python."""
    try:
        tree = ast.parse(code)
    except SyntaxError:
        return []
    return [item.name for item in tree.body if isinstance(item, ast.FunctionDef) and item.decorator_list]
