"""Findings about a drawn brain, each at its box."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from nrp_cockpit.designer.brain.edit import NO_SYNAPSES
from nrp_cockpit.designer.brain.interventions import FIELD, overrides_of
from nrp_cockpit.designer.brain.model import Brain, Projection, weight_unit
from nrp_cockpit.designer.brain.script import parts_at

_CODE = "BRAIN"


def brain_findings(brain: Brain, path: Path) -> list[dict[str, Any]]:
    """Return the findings that prevent a drawn brain from being built."""
    lines = dict(parts_at(brain))
    return [
        _finding(text, f"projection/{place}", path, lines[f"projection/{place}"])
        for place, one in enumerate(brain.projection)
        for text in _of_projection(brain, one)
    ]


def _of_projection(brain: Brain, projection: Projection) -> Iterator[str]:
    sizes = {one.name: one.size for one in brain.population}
    for name, cells in (
        (projection.source, projection.source_cells),
        (projection.target, projection.target_cells),
    ):
        if name not in sizes:
            yield f"'{projection.name}': there is no population '{name}'"
        elif cells and int(cells.partition(":")[2]) > sizes[name]:
            yield f"'{projection.name}': '{name}' has {sizes[name]} cells, so [{cells}] is out of range"
    if projection.target in sizes and not weight_unit(brain, projection):
        yield NO_SYNAPSES.format(projection.target)


def _finding(text: str, where: str, path: Path, line: int) -> dict[str, Any]:
    return {
        "code": _CODE, "weight": "error", "summary": text, "why": "", "fix": "", "count": 1,
        "file": str(path), "line": line, "path": where, "box": "",
    }  # fmt: skip


def located_in_brain(brain: Brain, path: Path, findings: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return findings about the experiment, with those about this script placed at their boxes."""
    found = []
    for finding in findings:
        here = finding["file"] is not None and Path(finding["file"]) == path and finding["line"]
        before = [name for name, line in parts_at(brain) if here and line <= finding["line"]]
        where = before[-1] if before else ""
        found.append({**finding, "path": where, "box": where if where.startswith("population") else ""})
    return at_interventions(brain, found)


def at_interventions(brain: Brain, findings: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return findings with those about an override of :func:`overrides_of` placed at its intervention."""
    _, *each = overrides_of(brain.intervention)
    places = {f"in the override '{override}': ": f"{FIELD}/{place}" for place, override in enumerate(each)}
    return [_at_intervention(places, finding) for finding in findings]


def _at_intervention(places: Mapping[str, str], finding: dict[str, Any]) -> dict[str, Any]:
    text = finding["summary"]
    found = next((before for before in places if text.startswith(before)), None)
    return finding if found is None else {
        **finding, "summary": text.removeprefix(found), "path": places[found]
    }  # fmt: skip
