"""Read an experiment from YAML: merge the files that it extends, apply overrides, report all mistakes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from pathlib import Path

from pydantic import ValidationError

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.backends import option_findings
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.schema_findings import schema_findings
from nrp_core.experiment.model.tree import Place, Tree
from nrp_core.experiment.reading.find import find_file
from nrp_core.experiment.reading.platforms import with_platform
from nrp_core.experiment.reading.yaml_tree import parse_tree, read_tree
from nrp_core.findings import Code, Finding, InvalidExperimentError

EXTENDS = "extends"

_NAMED = (
    ("events",), ("criteria",), ("aliases",), ("topics",),
    ("world", "robots"), ("world", "sensors"), ("brain", "populations"),
)  # fmt: skip
"""The mappings with names as keys, which an experiment chooses."""


def read_yaml(path: Path, overrides: Sequence[str] = ()) -> Experiment:
    """Read an experiment.

    Args:
        path: the YAML file. ``extends: other`` in it (a file or the name of a shipped experiment, or a
            list) merges it over others, in this order: mappings are merged, ``null`` removes a key, all else
            replaces. A file that several extend is merged once, first.
        overrides: ``dotted.key=value``, the value in YAML; if two set one key, the later one is used.

    Raises:
        InvalidExperimentError: anything is wrong; it carries all findings.
    """
    return experiment_of(reduce(_laid_over, _lineage(path.resolve()).values()), overrides)


def experiment_of(tree: Tree, overrides: Sequence[str] = ()) -> Experiment:
    """Return the experiment of a tree, from any kind of file.

    Args:
        tree: the keys and values of :class:`~nrp_core.experiment.model.experiment.Experiment`.
        overrides: as of :func:`read_yaml`.

    Raises:
        InvalidExperimentError: anything is wrong; it carries all findings.
    """
    _require_experiment(tree)
    tree = reduce(overridden, overrides, tree)
    findings = option_findings(tree)
    try:
        experiment = Experiment.model_validate(tree.plain())
    except ValidationError as error:
        findings += schema_findings(error, Experiment, tree)
    if findings:
        raise InvalidExperimentError(sorted(findings, key=_reading_order))
    return with_platform(experiment.with_source(tree).with_overrides(overrides))


def _require_experiment(tree: Tree) -> None:
    """Refuse the file of a sweep or a search, before all the keys that it lacks are listed.

    Raises:
        InvalidExperimentError: it is one.
    """
    if isinstance(tree.value, dict) and {"experiment", "vary"} <= tree.value.keys():
        command = "evolve" if "objective" in tree.value else "sweep"
        message = f"this file names an experiment and varies it: use nrp {command}"
        raise InvalidExperimentError([tree.place.finding(Code.NRP201, message)])


def _laid_over(tree: Tree, over: Tree) -> Tree:
    """Return a file merged over those that it extends; what it says must change something."""
    _require_effect(tree, over)
    return tree.merged(over)


def _require_effect(below: Tree, above: Tree) -> None:
    """Refuse keys that are removed and do not exist, and empty mappings, which remove nothing.

    Raises:
        InvalidExperimentError: there is one.
    """
    if not (isinstance(below.value, dict) and isinstance(above.value, dict)):
        return
    for name, child in above.value.items():
        place, old = child.key_place or child.place, below.value.get(name)
        if old is not None:
            if _is_idle(old, child):
                raise InvalidExperimentError([place.finding(Code.NRP202, _idle(str(name)))])
            _require_effect(old, child)
        elif child.value is None:
            message = f"there is no '{name}' to remove{did_you_mean(str(name), below.value)}"
            raise InvalidExperimentError([place.finding(Code.NRP201, message)])


def _is_idle(below: Tree, above: Tree) -> bool:
    return above.value == {} and isinstance(below.value, dict) and bool(below.value)


def _idle(key: str) -> str:
    return f"'{key}' is empty, which changes nothing: mappings are merged; '{key}: null' removes it"


def _reading_order(finding: Finding) -> tuple[str, int, int]:
    return str(finding.path or ""), finding.line or 0, finding.column or 0


def _lineage(path: Path, extending: tuple[Path, ...] = ()) -> dict[Path, Tree]:
    """Return the files that a file extends, each once, and itself; ``extending``: the files above it."""
    try:
        tree = read_tree(path)
    except ExperimentError as error:
        raise InvalidExperimentError([Finding.of(error, Code.NRP200)]) from error
    lineage: dict[Path, Tree] = {}
    own = dict(tree.value)
    named = own.pop(EXTENDS, None)
    for base in _bases(named):
        trail = (*extending, path)
        for known, below in _lineage(_base(base, trail), trail).items():
            lineage.setdefault(known, below)
    return {**lineage, path: replace(tree, value=own)}


def _bases(named: Tree | None) -> list[Tree]:
    """Return the names of the files that a file extends.

    Raises:
        InvalidExperimentError: one is given twice.
    """
    bases = [] if named is None else named.value if isinstance(named.value, list) else [named]
    for place, base in enumerate(bases):
        if base.value in [one.value for one in bases[:place]]:
            message = f"'{EXTENDS}' names '{base.value}' twice"
            raise InvalidExperimentError([base.place.finding(Code.NRP214, message)])
    return bases


def _base(base: Tree, extending: tuple[Path, ...]) -> Path:
    try:
        if not isinstance(base.value, str):
            raise ExperimentError(f"'{EXTENDS}' takes files or names of experiments, one or a list")
        path = find_file(base.value, base.place.folder)
    except ExperimentError as error:
        raise InvalidExperimentError([base.place.finding(Code.NRP214, str(error))]) from error
    if path in extending:
        round_trip = " -> ".join(file.name for file in (*extending[extending.index(path) :], path))
        message = f"an experiment cannot extend itself: {round_trip}"
        raise InvalidExperimentError([base.place.finding(Code.NRP214, message)])
    return path


def overridden(tree: Tree, override: str) -> Tree:
    """Return a tree with one ``dotted.key=value`` applied, the value in YAML.

    Raises:
        InvalidExperimentError: it cannot be applied.
    """
    place = Place(override=str(override))  # what is not a text cannot be read as one either
    key, equals, text = str(override).partition("=")
    keys = key.strip().split(".")
    try:
        if not equals or not all(keys):
            raise place.error("it must read 'dotted.key=value'")
        if not text.strip():
            _require_optional(tree, keys, place)
            raise place.error(f"there is no value; write '{key.strip()}=null' to remove it")
        value = parse_tree(text, place)
        if value.value is None:
            _require_optional(tree, keys, place)
        _require_event(tree, keys, place)
        if (old := tree.at(*keys)) is not None and _is_idle(old, value):
            raise place.error(f"it changes nothing: mappings are merged; '{key.strip()}=null' removes it")
        return tree.overridden(keys, value)
    except ExperimentError as error:
        raise InvalidExperimentError([Finding.of(error, Code.NRP215)]) from error


def _require_optional(tree: Tree, keys: Sequence[str], place: Place) -> None:
    """Refuse to remove a key that every experiment needs, or a name that does not exist.

    Raises:
        ExperimentError: it cannot be removed.
    """
    *outer, name = keys
    field = Experiment.model_fields.get(name)
    if not outer and field is not None and field.is_required():
        raise place.error(f"'{name}' cannot be removed: an experiment needs it")
    below = tree.at(*outer) if tuple(outer) in _NAMED else None
    if below is not None and isinstance(below.value, dict) and name not in below.value:
        raise place.error(f"there is no '{name}' to remove{did_you_mean(name, below.value)}")


def _require_event(tree: Tree, keys: Sequence[str], place: Place) -> None:
    """Refuse to change one setting of an event that does not exist: the new event would have no effect.

    Raises:
        ExperimentError: there is no such event.
    """
    if keys[0] != "events" or len(keys) < 3:
        return
    events = tree.at("events")
    names = list(events.value) if events is not None and isinstance(events.value, dict) else []
    if keys[1] not in names:
        raise place.error(
            f"there is no event '{keys[1]}'{did_you_mean(keys[1], names)} "
            f"(a new event is given whole: 'events.{keys[1]}={{at: ..., publish: ...}}')"
        )
