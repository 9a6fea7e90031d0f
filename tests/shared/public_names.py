"""The doors of the project and its public modules, as the reference lists them."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOORS = (
    "nrp_core", "nrp_core.brain", "nrp_core.experiment", "nrp_core.recording",
    "nrp_core.utilities", "nrp_core.world",
    "nrp_formats",
    "nrp_lab.comparison", "nrp_lab.sweep", "nrp_lab.evolve", "nrp_lab.benchmark",
    "nrp_lab.learning",
)  # fmt: skip


def public_modules() -> frozenset[str]:
    """The modules that the reference names, those with ``*`` at their end with all below them."""
    page = (ROOT / "docs" / "reference" / "python.md").read_text()
    table = page.partition("\n## Modules\n")[2].partition("\n## ")[0]
    return frozenset(re.findall(r"^\| `(nrp_(?:conformance|core|formats|lab)[\w.*]*)`", table, re.MULTILINE))
