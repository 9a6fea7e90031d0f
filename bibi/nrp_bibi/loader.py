"""Load the transfer functions of a BIBI file into the loop, through generated Python."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

from nrp_bibi.generation.transformation import transformed
from nrp_bibi.reader import read_bibi
from nrp_core.dsl import Listing, TransferFunction, load_transfer_functions
from nrp_core.errors import TransferFunctionError


def load_bibi(path: Path | str) -> list[TransferFunction]:
    """Return the transfer functions of a file, in its order; they share one namespace.

    Errors in generated code are reported with the line of the model.

    Raises:
        TransferFunctionError: the file cannot be read, is not valid, or declares no transfer function.
        ExperimentError: part of it is wrong; the error names the place.
    """
    path = Path(path)
    module = ModuleType(path.stem)
    functions: list[TransferFunction] = []
    for part in transformed(read_bibi(path), path):
        functions += load_transfer_functions(part.path, module=module, code=part.compiled())
    if not functions:
        raise TransferFunctionError("declares no transfer function; add a <transferFunction>", path=path)
    return functions


def bibi_listing(path: Path) -> Listing:
    """Return the Python generated from a file, without executing it.

    Raises:
        TransferFunctionError: the file cannot be read, or is not valid.
    """
    return Listing(tuple(part.source() for part in transformed(read_bibi(path), path)))
