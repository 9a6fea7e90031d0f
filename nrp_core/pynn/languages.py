"""The languages of scripts other than Python 3."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType, ModuleType
from typing import Protocol

from nrp_core._support.text import Misfit, decoded_python
from nrp_core.errors import NrpError
from nrp_core.registry import Registry
from nrp_core.scripts import compile_file, unbound_names


class Language(Protocol):
    """How scripts in a language are read and run."""

    @property
    def name(self) -> str:
        """What users call it."""

    def is_meant(self, script: str) -> bool:
        """Return whether a script that is Python 3, too, is in this language."""

    def compiled(self, path: Path) -> CodeType:
        """Return the code of a file.

        Raises:
            NrpError: it is not in this language.
        """

    def modules(self) -> Mapping[str, ModuleType]:
        """Return the modules that only scripts in this language import."""

    def running(self) -> AbstractContextManager[None]:
        """Return the context in which a script runs."""


LANGUAGES: Registry[type[Language]] = Registry("nrp_core.script_languages", "language of scripts")


@dataclass(frozen=True)
class ScriptReading:
    """The way to read one script.

    Args:
        language: its language; None for Python 3.
    """

    language: Language | None = None
    modules: Mapping[str, ModuleType] = field(default_factory=dict)

    def compiled(self, path: Path) -> CodeType:
        """Return the code of a file: in the script's language, or in its own beside a script in Python 3.

        Raises:
            SyntaxError: it is not Python.
            NrpError: it is not in the script's language.
        """
        language = self.language or reading_of(path).language
        return compile_file(path) if language is None else language.compiled(path)

    def remarks(self, script: Path) -> list[str]:
        """Return that a script is converted, if it is."""
        if self.language is None:
            return []
        return [f"'{script.name}' is in {self.language.name}, and is converted as it is read"]

    def running(self) -> AbstractContextManager[None]:
        """Return the context in which the script runs."""
        return nullcontext() if self.language is None else self.language.running()


def reading_of(script: Path) -> ScriptReading:
    """Return how to read a script: as Python 3, unless it is in another installed language."""
    text = decoded_python(script.read_bytes())
    code = "" if isinstance(text, Misfit) else text
    try:
        tree = ast.parse(code)
        compile(code, str(script), "exec", dont_inherit=True)
        if not unbound_names(tree) - vars(builtins).keys():
            return ScriptReading()
        is_python_3 = True
    except (SyntaxError, ValueError):
        is_python_3 = False
    for kind in LANGUAGES.load_all().values():
        language = kind()
        if is_python_3 and not language.is_meant(code):
            continue
        try:
            language.compiled(script)
        except NrpError:
            continue
        return ScriptReading(language, language.modules())
    return ScriptReading()
