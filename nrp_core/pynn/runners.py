"""Runners of scripts that were written for another simulator: ``python -m nrp_core.pynn --as NAME``.

An entry point in ``nrp_core.pynn_runners`` has the name after ``--as``, and is a function that runs a script
as the main program. :func:`run_as_main` does so with the modules of its
:class:`~nrp_core.network.pynn.dialects.Dialect`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType, ModuleType

from nrp_core.errors import NetworkError, NrpError
from nrp_core.network.files.script import scope_of
from nrp_core.network.pynn.dialects import Modules
from nrp_core.pynn.languages import reading_of
from nrp_core.registry import Registry

Runner = Callable[[Path, str | None, Mapping[str, str]], object]
"""Runs a script in a brain backend, None for the runner's own, with options; arguments are in ``sys.argv``.

Raises:
    NrpError: the script or an option is impossible; with file and line.
"""

RUNNERS: Registry[Runner] = Registry("nrp_core.pynn_runners", "runner of scripts")


def run_as_main(
    script: Path,
    sim: ModuleType,
    dialect: Modules,
    *,
    modules: Mapping[str, ModuleType] = MappingProxyType({}),
    replaced: Callable[[str], object] = str,
    refusing: ModuleType | None = None,
) -> ModuleType:
    """Run a script as the main program, in its language, and return its module.

    Args:
        script: the script; it can import the modules beside it.
        sim: the simulator of PyNN in the script; it warns of a conversion.
        dialect: the modules of the simulator that the script is written for.
        modules: further modules, by name.
        replaced: is called once with the name of each other simulator that is imported.
        refusing: a module that lacks some names of the one that it stands for.

    Raises:
        NrpError: the script does something unsupported, or uses a name that ``refusing`` lacks; with file and
            line.
        Exception: whatever else the script raises.
    """
    sys.path.insert(0, str(script.parent))
    reading = reading_of(script)
    sim.state.warn(reading.remarks(script))
    modules = {**reading.modules, **modules}
    scope = scope_of(sim, modules=modules, dialect=dialect, replaced=replaced, compiled=reading.compiled)
    try:
        with reading.running():
            return scope.run(script, name="__main__")
    except (NrpError, SyntaxError) as error:
        raise scope.located(error, NetworkError, script) from error
    except AttributeError as error:
        if refusing is None or error.obj is not refusing:
            raise
        refused = NetworkError(str(error)).with_traceback(error.__traceback__)
        raise scope.located(refused, NetworkError, script) from error
