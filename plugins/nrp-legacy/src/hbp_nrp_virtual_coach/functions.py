"""Transfer functions of a simulation: read, exchanged, added and deleted while it runs."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

from nrp_legacy.code import Source, ignore_note
from nrp_legacy.functions import part_source
from nrp_legacy.maker import LegacyMaker, ShimmedMaker

from hbp_nrp_virtual_coach.live import Live
from hbp_nrp_virtual_coach.settings import log
from hbp_nrp_virtual_coach.storage import Stored
from nrp_core.dsl import TransferFunction, load_transfer_functions
from nrp_core.errors import ExperimentError, NrpError, did_you_mean
from nrp_core.experiment import Experiment, Run, load_function_file


def sources_of(experiment: Experiment) -> dict[str, Source]:
    """Return the source of each Python transfer function by its name."""
    found: dict[str, Source] = {}
    for source in _sources(experiment):
        with suppress(NrpError):  # an omitted one
            found = {**each_of(source), **found}
    return found


def each_of(source: Source) -> dict[str, Source]:
    """Return the source of each function in a piece of code: the piece without the other functions.

    Raises:
        ExperimentError: it is not Python.
    """
    body = source.tree(ignore_note).body
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
        return load_function_file(path, experiment.function_parameters)
    code = Source.of_file(path).compiled(ignore_note)
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


class Functions(Live):
    """The part of a simulation that deals with transfer functions."""

    def __init__(self, stored: Stored, read: Callable[[], Experiment]) -> None:
        super().__init__(stored, read)
        self._sources = self._runner.call(lambda run: sources_of(run.experiment))
        self._saved = dict(self._sources)

    def print_transfer_functions(self) -> None:
        """Print the names of the transfer functions."""
        for name in self._names():
            print(name)

    def get_transfer_function(self, transfer_function_name: str) -> str:
        """Return the source of a transfer function, imports included.

        Raises:
            ExperimentError: it does not exist, or it is not written in Python.
        """
        self._require(transfer_function_name)
        if transfer_function_name not in self._sources:
            raise ExperimentError(
                f"transfer function '{transfer_function_name}' is not written in Python",
                subject=transfer_function_name,
            )
        return self._sources[transfer_function_name].text

    def edit_transfer_function(self, transfer_function_name: str, transfer_function: str) -> None:
        """Replace a transfer function between two steps; if the source is wrong, nothing changes.

        Raises:
            ExperimentError: it does not exist, or the source is wrong.
        """
        self._require(transfer_function_name)
        self._exchange(transfer_function_name, transfer_function)

    def add_transfer_function(self, transfer_function: str) -> None:
        """Add a transfer function between two steps.

        Raises:
            ExperimentError: the source is wrong, or a function of its name exists.
        """
        self._exchange(None, transfer_function)

    def delete_transfer_function(self, transfer_function_name: str) -> None:
        """Delete a transfer function between two steps.

        Raises:
            ExperimentError: it does not exist.
        """
        self._require(transfer_function_name)
        self._runner.call(lambda run: run.change(remove=[transfer_function_name]))
        self._sources.pop(transfer_function_name, None)

    def save_transfer_functions(self) -> None:
        """Write changed transfer functions into the files of the experiment.

        Raises:
            ExperimentError: a function does not have a file of its own in an experiment of yours.
        """
        changed = {name: one for name, one in self._sources.items() if self._saved.get(name) != one}
        for name, source in changed.items():
            old = self._saved.get(name)
            if (
                old is None
                or old.path == self._stored.file
                or each_of(Source.of_file(old.path)).get(name) != old
            ):
                raise ExperimentError(
                    f"'{name}' is not saved: it does not have a file of its own", subject=name
                )
            self._save(old.path, source.text)
            self._saved[name] = self._sources[name] = Source(source.text, old.path)

    def _exchange(self, name: str | None, source: str) -> None:
        path = self._draft(f"{name or 'added'}.py", source)
        drafts = each_of(Source.of_file(path))
        if not drafts:
            raise ExperimentError("the source does not declare a transfer function", path=path)
        taken = set(drafts) & (set(self._names()) - {name})
        if taken:
            known = min(taken)
            raise ExperimentError(f"the transfer function '{known}' already exists; edit it", subject=known)
        self._runner.call(lambda run: self._apply(run, name, drafts))
        if name is not None:
            self._sources.pop(name, None)
            if name not in drafts:
                log.warning(
                    "the transfer function '%s' is now called '%s', as in its text", name, min(drafts)
                )
        self._sources.update(drafts)

    def _apply(self, run: Run, name: str | None, drafts: dict[str, Source]) -> None:
        """Load the functions of a draft and let them take the place of one."""
        old = {one.name: one for one in run.loop.functions}
        functions = [
            one for path in {each.path for each in drafts.values()} for one in load(run.experiment, path)
        ]
        for function in functions:
            function.priority = (
                old[name].priority if name in old and not function.priority else function.priority
            )
        is_renamed = name in old and name not in {one.name for one in functions}
        known = [str(problem) for problem in run.problems]
        run.change(functions, [name] if name is not None and is_renamed else [])
        for problem in run.problems:
            if str(problem) not in known:
                log.warning("%s", problem)

    def _reapply(self, run: Run) -> None:
        """Give a new run the functions that the old one had."""
        new = sources_of(run.experiment)
        there = {one.name for one in run.loop.functions}
        for name, source in self._sources.items():
            if new.get(name) != source:
                self._apply(run, name if name in there else None, {name: source})
        run.change(remove=[name for name in there if name in new and name not in self._sources])

    def _names(self) -> list[str]:
        running = self._runner.call(lambda run: [one.name for one in run.loop.functions])
        return list(dict.fromkeys([*running, *self._sources]))

    def _require(self, name: str) -> None:
        names = self._names()
        if name not in names:
            raise ExperimentError(
                f"there is no transfer function '{name}'{did_you_mean(name, names)}", subject=name
            )
