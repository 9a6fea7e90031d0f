"""Interventions of an experiment, as parts of a model and as text of its file.

The experiment checks ranges and names when it reads the text.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import StringIO
from typing import Any, Final

from nrp_bibi.model.metamodel import Node, Value, attribute, child, features
from nrp_bibi.model.values import NUMBER, WORD, number_text
from ruamel.yaml import YAML

from nrp_core.clock import milliseconds
from nrp_core.experiment import InterventionSection

KEY: Final = "brain.interventions"
FIELD: Final = "intervention"
"""The field of a brain that has them."""


def _name(text: str) -> str:
    if not text.strip():
        raise ValueError
    return text.strip()


NAMED_CELLS = Value("NamedCells", _name, str, "the name of a population, view or group", WORD.facets)


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect(Node, abstract=True):
    """What an intervention does."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Silence(Effect):
    """Cuts all synapses from these cells, which fire without effect."""

    cells: str = attribute(NAMED_CELLS)


@dataclass(frozen=True, slots=True, kw_only=True)
class Lesion(Effect):
    """Cuts all synapses from and to these cells."""

    cells: str = attribute(NAMED_CELLS)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale(Effect):
    """Multiplies the weights of the synapses between these cells."""

    sources: str | None = attribute(NAMED_CELLS, None)
    targets: str | None = attribute(NAMED_CELLS, None)
    by: float = attribute(NUMBER)


@dataclass(frozen=True, slots=True, kw_only=True)
class Activate(Effect):
    """Drives each of these cells by Poisson spikes of its own."""

    cells: str = attribute(NAMED_CELLS)
    rate: float = attribute(NUMBER, unit="Hz")
    weight: float = attribute(NUMBER)
    duration: float | None = attribute(NUMBER, None, unit="ms")


@dataclass(frozen=True, slots=True, kw_only=True)
class Intervention(Node):
    """A change of the brain at a time."""

    at: float = attribute(NUMBER, 0, unit="ms")
    effect: Effect = child(Effect, name="kind")


def interventions_of(sections: Iterable[InterventionSection]) -> tuple[Intervention, ...]:
    """Return the interventions of an experiment."""
    return tuple(Intervention(at=_ms(one.at), effect=_effect(one)) for one in sections)


def yaml_of(interventions: Sequence[Intervention]) -> str:
    """Return the interventions as text of an experiment file."""
    section, _, key = KEY.partition(".")
    items = [f"\n    - {_written(one)}" for one in interventions]
    return f"{section}:\n  {key}:{''.join(items) or ' []'}\n"


def overrides_of(interventions: Sequence[Intervention]) -> list[str]:
    """Return one override for each intervention, so that messages name it."""
    there = ", ".join("{}" for _ in interventions)
    return [
        f"{KEY}=[{there}]",
        *(f"{KEY}.{place}={_written(one)}" for place, one in enumerate(interventions)),
    ]


# --


def _effect(section: InterventionSection) -> Effect:
    if section.silence is not None:
        return Silence(cells=section.silence)
    if section.lesion is not None:
        return Lesion(cells=section.lesion)
    if (scale := section.scale) is not None:
        return Scale(sources=scale.sources, targets=scale.targets, by=_short(scale.by))
    drive = section.activate
    assert drive is not None
    return Activate(
        cells=drive.cells,
        rate=_short(drive.rate),
        weight=_short(drive.weight),
        duration=None if drive.duration is None else _ms(drive.duration),
    )


def _ms(t_ns: int) -> float:
    return _short(milliseconds(t_ns))


def _short(number: float) -> float:
    """Return a whole number as such, as a form shows it."""
    return int(number) if number == int(number) else number


def _written(intervention: Intervention) -> str:
    effect = intervention.effect
    given = _given(effect)
    kind = type(effect).__name__.lower()
    data = {kind: given["cells"] if list(given) == ["cells"] else given}
    if intervention.at:
        data |= {"at": _given(intervention)["at"]}
    yaml, text = YAML(), StringIO()
    yaml.default_flow_style, yaml.width = True, 1_000_000  # in one line
    yaml.dump(data, text)
    return text.getvalue().strip()


def _given(node: Node) -> dict[str, Any]:
    """Return the values of a node that are given; those with a unit with it."""
    found = {}
    for feature in features(type(node)):
        value = getattr(node, feature.field)
        if isinstance(feature.of, Value) and value is not None:
            found[feature.field] = f"{number_text(value)} {feature.unit}" if feature.unit else value
    return found
