"""Make models from Python transfer functions."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path

from nrp_bibi.generation.imports import imports
from nrp_bibi.generation.transformation import generate
from nrp_bibi.model.functions import Bibi, BIBITransferFunction, PythonTransferFunction, TransferFunction
from nrp_bibi.reverse.functions import as_function
from nrp_bibi.reverse.imported import bound_by, imported, written_out
from nrp_bibi.reverse.refusal import NotExpressibleError
from nrp_bibi.reverse.selectors import Normalized
from nrp_core.dsl import message_packages
from nrp_core.errors import TransferFunctionError

_IMPORTS = (ast.Import, ast.ImportFrom)


def reverse_file(path: Path) -> Bibi:
    """Return the model of a Python file; see :func:`reverse`.

    Raises:
        TransferFunctionError: it cannot be read, or is not Python.
    """
    try:
        return reverse(path.read_text(encoding="utf-8-sig"), path)
    except OSError as error:
        raise TransferFunctionError(f"cannot be read: {error.strerror}", path=path) from None
    except UnicodeDecodeError:
        raise TransferFunctionError("cannot be read: it is not UTF-8 text", path=path) from None


def reverse(code: str, path: Path) -> Bibi:
    """Return the model of a file of transfer functions.

    Functions that building blocks can express become building blocks. Other functions and other
    statements are kept as Python.

    Args:
        code: the content of the file.
        path: its path, for messages.

    Raises:
        TransferFunctionError: it is not Python.
    """
    try:
        tree = ast.parse(code)
    except SyntaxError as error:
        raise TransferFunctionError(
            f"this is not Python: {error.msg}", path=path, line=error.lineno
        ) from None
    names = imported(tree)
    found: list[BIBITransferFunction | ast.stmt] = []
    for statement in tree.body:
        if _switches_off(statement, found):
            found[-1] = replace(found[-1], active=False)  # type: ignore[type-var]
        else:
            found.append(_expressed(statement, names) or statement)
    return Bibi(transfer_function=tuple(_grouped(found, tree, code)))


def _grouped(
    found: list[BIBITransferFunction | ast.stmt], tree: ast.Module, code: str
) -> Iterator[TransferFunction]:
    """Yield building blocks, and the code between them, one piece each, without known imports."""
    blocks = tuple(one for one in found if isinstance(one, BIBITransferFunction))
    known = {*imports(Bibi(transfer_function=blocks)), *(f"import {name}.msg" for name in message_packages())}
    used = _names([one for one in found if isinstance(one, ast.stmt)])
    spent = _names(tree.body) - used
    needed = (one for one in found if not (isinstance(one, _IMPORTS) and _is_spare(one, known, used, spent)))
    for is_python, run in groupby(needed, lambda one: isinstance(one, ast.stmt)):
        if is_python:
            yield _kept([one for one in run if isinstance(one, ast.stmt)], code)
        else:
            yield from (one for one in run if isinstance(one, BIBITransferFunction))


def _switches_off(statement: ast.stmt, found: Sequence[object]) -> bool:
    """Return whether a statement deactivates the building blocks right before it."""
    last = found[-1] if found else None
    if not isinstance(last, BIBITransferFunction):
        return False
    return ast.unparse(statement) == f"{last.name}.active = False"


def _expressed(statement: ast.stmt, names: Mapping[str, str]) -> BIBITransferFunction | None:
    """Return a function as building blocks, if they generate exactly the same function."""
    if not isinstance(statement, ast.FunctionDef):
        return None
    try:
        whole = written_out(statement, names)
        function = as_function(whole)
        again = ast.parse(
            generate(Bibi(transfer_function=(function,)), Path("model.bibi"), with_imports=False)
        )
    except (NotExpressibleError, TransferFunctionError):
        return None
    same = _dump(again.body[-1:]) == _dump([whole])
    return function if same else None


def _dump(statements: list[ast.stmt]) -> str:
    return ast.dump(Normalized().visit(ast.Module(statements, [])))


def _kept(statements: list[ast.stmt], code: str) -> PythonTransferFunction:
    """Return the source text of statements, with the comments between them."""
    lines = code.split("\n")
    first, last = _begin(statements[0]), statements[-1].end_lineno
    return PythonTransferFunction(code="\n".join(lines[first - 1 : last]))


def _begin(statement: ast.stmt) -> int:
    decorators: list[ast.expr] = getattr(statement, "decorator_list", [])
    return min([statement.lineno, *(decorator.lineno for decorator in decorators)])


def _names(statements: Sequence[ast.stmt]) -> set[str]:
    """Return the names that statements use."""
    nodes = (node for one in statements for node in ast.walk(one))
    return {node.id for node in nodes if isinstance(node, ast.Name)}


def _is_spare(
    statement: ast.Import | ast.ImportFrom, known: set[str], used: set[str], spent: set[str]
) -> bool:
    """Whether an import is generated anyway, or only functions that became building blocks used it."""
    if isinstance(statement, ast.Import) and _imports(statement) <= known:
        return True
    names = {name for name, _ in bound_by(statement)}
    return names.isdisjoint(used) and not names.isdisjoint(spent)


def _imports(statement: ast.Import) -> set[str]:
    """Return the statement as one for each module."""
    return {ast.unparse(ast.Import([alias])) for alias in statement.names}
