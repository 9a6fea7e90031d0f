"""Scripts of PyNN in Python 2."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from types import CodeType, ModuleType

from nrp_legacy.code import compiled_file, without_deprecation_warnings
from nrp_legacy.python2 import uses_python_2
from nrp_legacy.shims.libraries import renamed_libraries


class Python2:
    """How a script in Python 2 is read and run, see :class:`nrp_core.pynn.languages.Language`."""

    name = "Python 2"

    def is_meant(self, script: str) -> bool:
        """Return whether a script that is also Python 3 uses features of Python 2 alone."""
        return uses_python_2(script)

    def compiled(self, path: Path) -> CodeType:
        """Return the code of a file.

        Raises:
            TransferFunctionError: it is neither Python 3 nor Python 2.
        """
        return compiled_file(path)

    def modules(self) -> Mapping[str, ModuleType]:
        """Return the modules that have another name today."""
        return renamed_libraries()

    def running(self) -> AbstractContextManager[None]:
        """Return a context without warnings about old code."""
        return without_deprecation_warnings()
