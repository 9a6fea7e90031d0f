"""Cells of NESTML, which a program of its own distribution turns into equations."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, Final

from nrp_core.brain.pynn.equation_cells import equation_cell
from nrp_core.errors import NetworkError
from nrp_core.paths import existing_file

PROGRAM: Final = "nrp-nestml"
INSTALL: Final = "pip install nrp-nestml"
_TIME_LIMIT_S: Final = 300


def nestml_cell(path: Path | str) -> type:
    """Return the neuron in a file of NESTML as a cell type of equations.

    Its parameters and variables have the names and units of the file; a weight is in the unit of the variable
    that a spike changes, and currents are injected into the continuous port.

    Args:
        path: the file.

    Raises:
        NetworkError: the program ``nrp-nestml`` is not installed, or the neuron has something that
            cells in equations do not have; the message names the line.
    """
    file = existing_file(path)
    try:
        arguments = _translated(file)
    except ValueError as error:
        raise NetworkError(str(error), path=file) from error
    return equation_cell(**arguments)


def _translated(file: Path) -> dict[str, Any]:
    """Return what the program prints.

    Raises:
        ValueError: it is not installed, or says that it cannot translate the file.
    """
    program = shutil.which(PROGRAM, path=str(Path(sys.executable).parent)) or shutil.which(PROGRAM)
    if program is None:
        raise ValueError(f"cells of NESTML need the program {PROGRAM}; try: {INSTALL}")
    try:
        done = subprocess.run(
            [program, str(file)], capture_output=True, text=True, check=False, timeout=_TIME_LIMIT_S
        )
    except subprocess.TimeoutExpired:
        raise ValueError(f"{PROGRAM} has not answered in {_TIME_LIMIT_S} s") from None
    try:
        found: dict[str, Any] = json.loads(done.stdout)
    except json.JSONDecodeError:
        said = done.stderr.strip().splitlines()[-1:] or ["nothing"]
        raise ValueError(f"{PROGRAM} failed with exit code {done.returncode} and said: {said[0]}") from None
    if "error" in found:
        raise ValueError(found["error"])
    return found
