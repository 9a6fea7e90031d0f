"""Give the transfer functions of a BIBI file to the loop, through the Python that they stand for."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

from nrp_bibi.generate.transformation import transformed
from nrp_bibi.reader import read_bibi
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.loading.listing import Listing
from nrp_core.dsl.loading.loader import load_transfer_functions
from nrp_core.errors import TransferFunctionError


def load_bibi(path: Path | str) -> list[TransferFunction]:
    """Return the transfer functions of a file, in its order; they share the names that Python in it defines.

    What goes wrong in generated code is reported with the line of the model.

    Raises:
        TransferFunctionError: the file cannot be read, has no meaning, or declares nothing.
        ExperimentError: something in it is wrong; it says where.
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
    """Return the Python that a file stands for, without executing it.

    Raises:
        TransferFunctionError: the file cannot be read, or has no meaning.
    """
    return Listing(tuple(part.source() for part in transformed(read_bibi(path), path)))
