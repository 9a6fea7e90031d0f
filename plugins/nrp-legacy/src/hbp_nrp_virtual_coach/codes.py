"""The source of each transfer function of an experiment, and functions from new sources."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from nrp_legacy.code import Source
from nrp_legacy.functions import part_source
from nrp_legacy.maker import LegacyMaker, ShimmedMaker
from nrp_legacy.notes import unnoted

from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.loading.loader import load_transfer_functions
from nrp_core.errors import NrpError
from nrp_core.experiment.making.maker import load_functions
from nrp_core.experiment.model.experiment import Experiment


def sources_of(experiment: Experiment) -> dict[str, Source]:
    """Return the source of each transfer function by its name, as far as it is Python."""
    found: dict[str, Source] = {}
    for source in _sources(experiment):
        with suppress(NrpError):  # one that was left out
            found = {**each_of(source), **found}
    return found


def each_of(source: Source) -> dict[str, Source]:
    """Return the source of each function in a piece of code: the piece without the other functions.

    Raises:
        ExperimentError: it is not Python.
    """
    body = source.tree(unnoted).body
    places = {
        one.name: _lines(one, source)
        for one in body
        if isinstance(one, ast.FunctionDef) and one.decorator_list
    }
    lines = source.text.splitlines(keepends=True)
    texts: dict[str, Source] = {}
    for name in places:
        others = {line for other, span in places.items() if other != name for line in span}
        kept = "".join(line for i, line in enumerate(lines) if i not in others)
        texts[name] = source if not others else Source(kept, source.path, source.first_line)
    return texts


def load(experiment: Experiment, path: Path) -> list[TransferFunction]:
    """Return the transfer functions of a new file, with the names that the experiment gives its functions.

    Raises:
        ExperimentError: it is wrong.
    """
    maker = experiment.maker
    if not isinstance(maker, ShimmedMaker):
        return load_functions(path, experiment.function_parameters)
    code = Source.of_file(path).compiled(unnoted)
    return load_transfer_functions(path, module=maker.names.module, code=code, scope=maker.names.scope)


def _lines(function: ast.FunctionDef, source: Source) -> range:
    """Return the indices of a function's lines in its source, decorators included."""
    first = min(one.lineno for one in function.decorator_list)
    return range(first - source.first_line, (function.end_lineno or function.lineno) - source.first_line + 1)


def _sources(experiment: Experiment) -> Iterator[Source]:
    maker = experiment.maker
    if not isinstance(maker, LegacyMaker):
        yield from (Source.of_file(path) for path in experiment.transfer_functions if path.suffix == ".py")
        return
    for element in maker.bibi.functions:
        with suppress(NrpError):  # a file that does not exist
            yield from part_source(element, maker.bibi.element, maker.library)
