"""Prints models of NESTML as arguments of ``EquationCell`` or ``EquationSynapse``, in JSON: nrp-nestml FILE.

For several files it prints one object whose keys are their names without the suffix.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from nrp_nestml.cell import model_of
from nrp_nestml.errors import NestmlError


def main() -> int:
    """Print the model, or ``{"error": ...}`` and end with an exit code of 1."""
    paths = [Path(one) for one in sys.argv[1:]]
    if not paths:
        print("usage: nrp-nestml FILE.nestml ...", file=sys.stderr)
        return 2
    stems = [path.stem for path in paths]
    if twice := sorted({one for one in stems if stems.count(one) > 1}):
        print(f"error: several files have the name '{twice[0]}' without the suffix", file=sys.stderr)
        return 2
    found = {path.stem: _translated(path) for path in paths}
    print(json.dumps(found if len(paths) > 1 else found[paths[0].stem], indent=1))
    return int(any("error" in one for one in found.values()))


def _translated(path: Path) -> dict[str, Any]:
    try:
        return model_of(path)
    except NestmlError as error:
        print(f"error: {path}: {error}", file=sys.stderr)
        return {"error": str(error)}


if __name__ == "__main__":
    sys.exit(main())
