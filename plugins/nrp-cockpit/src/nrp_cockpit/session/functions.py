"""Transfer functions of a run, edited while it runs."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from nrp_cockpit.session.completion import words_of
from nrp_cockpit.session.costs import Costs
from nrp_cockpit.session.drafts import Drafts
from nrp_cockpit.session.findings import finding_data, function_data
from nrp_core import validate
from nrp_core.checks.warnings import new_warnings
from nrp_core.errors import ExperimentError, NrpError
from nrp_core.experiment import Experiment, Run, load_function_file
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level
from nrp_core.utilities import replace_file

T = TypeVar("T")

LANGUAGES = {".py": "python", ".bibi": "bibi", ".xml": "bibi"}


class Functions:
    """The transfer functions of a run and their files.

    Edited files run from drafts; the files on disk stay unchanged until they are saved.

    Args:
        run: the run.
        before: the functions of the run that this one replaces, whose files are known as that run read them.

    Attributes:
        drafts: of the files that were edited.
        costs: the running times of the functions.
    """

    def __init__(self, run: Run, before: Functions | None = None) -> None:
        self._run = run
        self._files = {str(path): path for path in run.experiment.transfer_functions}
        self._running = _on_disk(self._files)
        self._saved: Mapping[str, str] = {**self._running, **(before._saved if before else {})}
        self._names: dict[str, list[str]] = defaultdict(list)
        for function in run.loop.functions:
            if str(function.place.path) in self._files:  # those of old experiments have no file of their own
                self._names[str(function.place.path)].append(function.name)
        self.drafts = Drafts()
        self.costs = Costs(run.loop)
        self._doubts: tuple[Finding, ...] = ()
        run.reporters.append(lambda: self._doubts)

    @property
    def texts(self) -> dict[str, str]:
        """The texts that the run uses, by the names of their files."""
        return dict(self._running)

    @property
    def files(self) -> tuple[str, ...]:
        """The names of the files."""
        return tuple(self._files)

    def include(self, path: Path) -> None:
        """Add a file, which need not exist before it is applied."""
        self._files.setdefault(str(path), path)

    def files_with(self, path: Path, instead_of: Collection[Path]) -> dict[str, Path]:
        """Return the files with some of them replaced."""
        kept = {name: one for name, one in self._files.items() if one not in instead_of}
        return {**kept, str(path): path}

    def data(self) -> dict[str, Any]:
        """Return the functions and their files."""
        functions = []
        for function in self._run.loop.functions:
            shown = function_data(function, self._run, self.costs.of(function.name))
            functions.append(self.drafts.in_place(shown))
        return {"functions": functions, "files": [self._file_data(name) for name in self._there()]}

    def doubt(self) -> None:
        """Add the findings of a check to the problems of the run, if it was opened without a check."""
        self._note(_findings(self._run.experiment))

    def close(self) -> None:
        """Remove the drafts."""
        self.drafts.close()

    # -- services

    def check(self, files: Mapping[str, str]) -> dict[str, Any]:
        """Return the findings about the experiment with these texts in place of its files."""
        return self.check_in(self._run.experiment, files)

    def check_in(
        self, experiment: Experiment, files: Mapping[str, str], there: Mapping[str, Path] | None = None
    ) -> dict[str, Any]:
        """Return the findings about another experiment with these texts in place of the files of this one.

        Args:
            experiment: the experiment.
            files: the texts.
            there: the files that count, by their names; by default those of the run.
        """
        there = self._files if there is None else there
        experiment = self._drafted(experiment, self._texts(files, there), there)
        try:
            return {"findings": self._shown(_findings(experiment))}
        finally:
            self.drafts.remove(experiment.transfer_functions)

    def apply(
        self,
        files: Mapping[str, str],
        there: Mapping[str, Path] | None = None,
        base: Mapping[str, str] | None = None,
        *,
        check: bool = True,
    ) -> dict[str, Any]:
        """Continue the run with these texts in place of its files, all of them or none.

        Args:
            files: the texts.
            there: the new files of the run, by name; by default those that it has.
            base: the texts that some of them were edited from.
            check: whether the experiment is checked before, which takes half a second; otherwise only what
                cannot be loaded is refused, and :meth:`recheck` follows.

        Returns:
            Whether they are applied, and the findings that prevent it.

        Raises:
            ExperimentError: the run has another text than one of ``base``, because another client changed it.
        """
        self._require_base(base)
        there = self._files if there is None else there
        texts = self._texts(files, there)
        experiment = self._drafted(self._run.experiment, texts, there)
        checked = _findings(experiment) if check else []
        found = self._errors(experiment, checked)
        shown = self._shown(found)
        if found:
            self.drafts.remove(experiment.transfer_functions)
        else:
            self._running = texts
            if check:
                self._note(checked)
            if there is not self._files:
                self._files = dict(there)
        return {"applied": not found, "findings": shown}

    def recheck(self) -> dict[str, Any]:
        """Check the texts that run, and return the findings; any thread may call this."""
        running = self._running
        experiment = self._drafted(self._run.experiment, running, self._files)
        try:
            checked = _findings(experiment)
            if self._running is running:
                self._note(checked)
            return {"findings": self._shown(checked)}
        finally:
            self.drafts.remove(experiment.transfer_functions)

    def revert(self) -> None:
        """Continue the run with the files on disk."""
        on_disk = _on_disk(self._files)
        changed = on_disk != self._running
        self._change({name: self._files[name] for name in on_disk})
        self._running = self._saved = on_disk
        if changed:  # the findings about the same texts are the same, and a check takes a second
            self.doubt()

    def save(self, files: Mapping[str, str], base: Mapping[str, str] | None = None) -> None:
        """Write texts to the files of the experiment, each as a whole.

        Args:
            files: the texts.
            base: the texts that some of them were edited from.

        Raises:
            ExperimentError: one is not a file of the experiment, was changed by somebody else (on the disk or
                in the run), or cannot be written.
        """
        _require(files, self._files)
        self._require_base(base)
        on_disk = _on_disk({name: self._files[name] for name in files})
        for name, text in files.items():
            if on_disk.get(name, text) not in (text, self._saved.get(name)):
                raise ExperimentError(
                    "was changed on the disk since the run has read it, and is not overwritten; "
                    "'Revert to disk' takes the change",
                    path=self._files[name],
                )
        for name, text in files.items():
            replace_file(self._files[name], text)
            self._saved = {**self._saved, name: text}

    def activate(self, name: str, active: bool) -> None:
        """Activate or deactivate a function."""
        self._run.activate(name, active)

    def complete(self) -> dict[str, Any]:
        """Return the words that an editor suggests."""
        return {"words": list(words_of(self._run))}

    # -- changing

    def _require_base(self, base: Mapping[str, str] | None) -> None:
        """Refuse texts whose originals differ from the running ones."""
        for name, text in (base or {}).items():
            if self._running.get(name, text) != text:
                raise ExperimentError(
                    f"somebody else has changed {Path(name).name} since you began to edit it"
                )

    def _texts(self, files: Mapping[str, str], there: Mapping[str, Path]) -> dict[str, str]:
        """Return these texts and, of the other files that count, those that run."""
        return {**{name: text for name, text in self._running.items() if name in there}, **files}

    def _drafted(
        self, experiment: Experiment, texts: Mapping[str, str], there: Mapping[str, Path]
    ) -> Experiment:
        """Return an experiment with these texts for its files: drafts of those that differ from the disk."""
        _require(texts, there)
        on_disk = _on_disk(there)
        new = {name: text for name, text in texts.items() if text != on_disk.get(name)}
        paths = (
            self.drafts.write(path, new[name]) if name in new else path
            for name, path in there.items()
            if name in texts or path.exists()
        )
        return experiment.model_copy(update={"transfer_functions": tuple(paths)})

    def _there(self) -> list[str]:
        """Return the names of the files that run or can run."""
        return [name for name, path in self._files.items() if name in self._running or path.exists()]

    def _note(self, checked: Iterable[Finding]) -> None:
        """Add these findings to the problems of the run."""
        self._doubts = tuple(new_warnings(checked, self._run.plan.warnings))

    def _errors(self, experiment: Experiment, checked: Iterable[Finding]) -> list[Finding]:
        """Change to the functions of an experiment, or return those of its findings that prevent it."""
        found = [each for each in checked if each.level is Level.ERROR]
        if not found:
            try:
                self._change(
                    {self.drafts.in_place(str(path)): path for path in experiment.transfer_functions}
                )
            except InvalidExperimentError as error:
                found = list(error.findings)
            except ExperimentError as error:
                found = [Finding.of(error, Code.NRP210)]
        return found

    def _change(self, files: Mapping[str, Path]) -> None:
        """Exchange the functions of all files for those of files or their drafts in one transaction."""
        given = self._run.experiment.function_parameters
        new = _again(lambda: {name: load_function_file(path, given) for name, path in files.items()})
        names = {function.name for functions in new.values() for function in functions}
        there = {function.name for function in self._run.loop.functions}
        gone = [
            name for known in self._names.values() for name in known if name not in names and name in there
        ]
        self._run.change([function for functions in new.values() for function in functions], gone)
        self._names.update({file: [each.name for each in functions] for file, functions in new.items()})

    # -- data

    def _shown(self, findings: Iterable[Finding]) -> list[Any]:
        return [self.drafts.in_place(finding_data(each)) for each in findings]

    def _file_data(self, name: str) -> dict[str, Any]:
        path = self._files[name]
        return source_file(name, path, self._running.get(name), editable=os.access(path, os.W_OK))


def _require(names: Iterable[str], there: Mapping[str, Path]) -> None:
    for name in names:
        if name not in there:
            raise ExperimentError(f"'{name}' is not a file with transfer functions of this experiment")


def _on_disk(files: Mapping[str, Path]) -> dict[str, str]:
    """Return the texts of files on disk, without files that cannot be read."""
    texts = {}
    for name, path in files.items():
        with suppress(OSError, UnicodeDecodeError):
            texts[name] = path.read_text(encoding="utf-8")
    return texts


def source_file(name: str, path: Path, text: str | None = None, *, editable: bool) -> dict[str, Any]:
    """Return a file with its text, by default the one on disk."""
    try:
        text = path.read_text(encoding="utf-8") if text is None else text
    except (OSError, UnicodeDecodeError) as error:
        text = f"# it cannot be read: {error}\n"
    return {
        "path": name, "source": text, "language": LANGUAGES.get(path.suffix, "python"), "editable": editable
    }  # fmt: skip


def _findings(experiment: Experiment) -> list[Finding]:
    try:
        return _again(lambda: validate(experiment))
    except InvalidExperimentError as error:
        return list(error.findings)
    except NrpError as error:
        return [Finding(Code.NRP210, str(error))]


_ATTEMPTS = 5


def _again(call: Callable[[], T]) -> T:
    """Call a function that parses Python, which Python 3.11 cannot do in two threads at once.

    It then raises a SystemError in one of them: https://github.com/python/cpython/issues/106905.
    """
    for _ in range(_ATTEMPTS - 1):
        with suppress(SystemError):
            return call()
    return call()
