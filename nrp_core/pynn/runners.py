"""Runners of scripts that were written for another simulator: ``python -m nrp_core.pynn --as NAME``.

An entry point in ``nrp_core.pynn_runners`` has the name after ``--as``, and is a function that runs a script
as the main program. :func:`~nrp_core.network.files.script.scope_of` makes the modules that it imports,
those of its :class:`~nrp_core.network.pynn.dialects.Dialect` among them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from nrp_core.registry import Registry

Runner = Callable[[Path, str | None, Mapping[str, str]], object]
"""Runs a script in a brain backend, None for the runner's own, with options; arguments are in ``sys.argv``.

Raises:
    NrpError: the script or an option is impossible; with file and line.
"""

RUNNERS: Registry[Runner] = Registry("nrp_core.pynn_runners", "runner of scripts")
