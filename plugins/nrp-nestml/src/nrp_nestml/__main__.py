"""Prints the neuron in a file as the arguments of ``EquationCell``, in JSON: nrp-nestml FILE."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from nrp_nestml.cell import cell_of
from nrp_nestml.errors import NestmlError


def main() -> int:
    """Print the cell, or ``{"error": ...}`` and end with an exit code of 1."""
    if len(sys.argv) != 2:
        print("usage: nrp-nestml FILE.nestml", file=sys.stderr)
        return 2
    try:
        found = cell_of(Path(sys.argv[1]))
    except NestmlError as error:
        print(json.dumps({"error": str(error)}))
        print(f"error: {sys.argv[1]}: {error}", file=sys.stderr)
        return 1
    print(json.dumps(found, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
