"""The methods of an experiment in words and tables.

The tables of the network follow Nordlie, Gewaltig and Plesser (2009), PLoS Comput. Biol. 5:e1000456.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from io import StringIO
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from ruamel.yaml import YAML

from nrp_core.brain import Network, Population, Projection
from nrp_core.clock import seconds
from nrp_core.experiment import Plan
from nrp_core.world import Model

_MAX_JOINTS = 60
_TIMES = ("at", "after", "time")
"""Settings that are times, recorded in ns."""


def _row(*cells: str) -> str:
    """Return a row of a table in Markdown."""
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"


def methods_page(
    plan: Plan, settings: Mapping[str, Any], seeds: tuple[int, ...], conditions: tuple[str, ...]
) -> str:
    """Return the page, in Markdown.

    Args:
        plan: the plan of one of the runs.
        settings: the settings of this run, as recorded.
        seeds: the seeds of all runs.
        conditions: brain and world of each kind of run, and its wiring.
    """
    robots = [model for model in plan.scene.models if not model.static]
    return template("methods.md.j2").render(
        experiment=plan.experiment,
        network=plan.network,
        populations=list(_populations(plan.network)),
        cells=list(_cells(plan.network)),
        projections=list(_projections(plan.network)),
        synapses=list(_synapses(plan.network)),
        robots=robots,
        joints=[row for robot in robots for row in _joints(robot)],
        parts=[row for robot in robots for row in _parts(robot)],
        functions=[str(one).replace(f"{Path(one.place.path).parent}/", "") for one in plan.functions],
        chapters=list(_chapters(settings)),
        seeds=seeds,
        conditions=conditions,
        step_ms=seconds(plan.experiment.timestep) * 1e3,
        duration_s=seconds(plan.experiment.duration),
        mass_kg=_mass_kg,
        gravity=" ".join(f"{one:g}" for one in plan.scene.gravity),
    )


def template(name: str) -> jinja2.Template:
    """Return a template of a page in Markdown."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("nrp_lab.paper"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,
    )
    return environment.get_template(name)


def _chapters(settings: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the title and the text of the parts of the experiment that are data."""
    for key, title in (("events", "Events"), ("criteria", "Criteria")):
        if settings.get(key):
            text = StringIO()
            YAML().dump(_written(settings[key]), text)
            yield title, text.getvalue().rstrip()


def _written(value: Any, key: str = "") -> Any:
    """Return recorded settings in their written form: times in s, without unset ones."""
    if isinstance(value, Mapping):
        return {name: _written(one, name) for name, one in value.items() if one not in (None, 0)}
    if isinstance(value, list):
        return [_written(one) for one in value]
    return f"{seconds(value):g} s" if key in _TIMES and isinstance(value, int) else value


def values_text(values: Any) -> str:
    """Return a number, or the range and mean of several."""
    array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    if not array.size:
        return "-"
    low, high = float(array.min()), float(array.max())
    return f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}, mean {float(array.mean()):.6g}"


def _populations(network: Network) -> Iterator[str]:
    for population in network.populations.values():
        kind = "input" if population.is_source else "neurons"
        yield _row(population.label, kind, population.cell_type, str(population.size))


def _cells(network: Network) -> Iterator[str]:
    """Yield a row for each cell type with each set of parameters."""
    seen: dict[tuple[str, str], list[str]] = {}
    for population in network.populations.values():
        seen.setdefault((population.cell_type, _parameters(population)), []).append(population.label)
    for (cell_type, parameters), labels in seen.items():
        yield _row(cell_type, ", ".join(labels), parameters)


def _parameters(population: Population) -> str:
    named = {name: values_text(values) for name, values in population.parameters.items()}
    return ", ".join(f"{name} = {text}" for name, text in named.items())


def _projections(network: Network) -> Iterator[str]:
    for projection in network.projections:
        size = network.populations[projection.post].size
        unit = network.populations[projection.post].weight_unit(projection.receptor)
        yield _row(
            projection.label, f"{projection.pre} to {projection.post}",
            _connector(projection), f"{projection.size} ({projection.size / size:.3g} a cell)",
            projection.receptor, f"{values_text(projection.weight)} {unit.text}",
            f"{values_text(projection.delay_ms)} ms",
        )  # fmt: skip


def _connector(projection: Projection) -> str:
    given = projection.origin.parameters
    return projection.origin.connector + (f" ({_assignments(given)})" if given else "")


def _synapses(network: Network) -> Iterator[str]:
    """Yield a row for each kind of synapse that changes its weight."""
    for projection in network.projections:
        if projection.synapse_type != "static":
            rules = ", ".join(f"{part}: {rule}" for part, rule in projection.plasticity.items())
            values = {name: values_text(each) for name, each in projection.synapse_parameters.items()}
            yield _row(projection.label, projection.synapse_type, rules or "-", _assignments(values))


def _assignments(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in values.items())


def _mass_kg(model: Model) -> float:
    return sum(link.inertial.mass for link in model.links if link.inertial is not None)


def _joints(model: Model) -> Iterator[str]:
    moving = [joint for joint in model.joints if joint.kind != "fixed"]
    for joint in moving[:_MAX_JOINTS]:
        limits = "-" if np.isinf(joint.lower) else f"{joint.lower:.4g} to {joint.upper:.4g}"
        yield _row(f"{model.name}/{joint.name}", joint.kind, f"{joint.parent} to {joint.child}", limits)
    if len(moving) > _MAX_JOINTS:
        yield _row(f"{model.name}: {len(moving) - _MAX_JOINTS} more joints", "", "", "")


def _parts(model: Model) -> Iterator[str]:
    """Yield the sensors and drives of a robot."""
    parts: list[Any] = [*(sensor for link in model.links for sensor in link.sensors), *model.drives]
    for part in parts:
        given = {one.name: getattr(part, one.name) for one in fields(part)}
        topic = given.get("topic") or given.get("command_topic") or "-"
        rate_hz = given.get("rate_hz")
        rate = f"{rate_hz:g} Hz" if isinstance(rate_hz, int | float) and rate_hz else "-"
        yield _row(f"{model.name}/{given.get('name', '-')}", type(part).__name__, str(topic), rate)
