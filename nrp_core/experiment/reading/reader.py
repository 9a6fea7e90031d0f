"""Read an experiment from YAML: merge the files that it extends, apply overrides, report all mistakes.

:func:`experiment_schema` describes the file for editors, and :class:`Platform` those of other platforms.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from nrp_core.brain.backends import brains
from nrp_core.errors import BackendError, ExperimentError, did_you_mean
from nrp_core.experiment.backends import option_findings
from nrp_core.experiment.model.collector import schema_findings
from nrp_core.experiment.model.experiment import BrainSection, Experiment, PartMaker, WorldSection
from nrp_core.experiment.model.section import Place, Section, Tree
from nrp_core.experiment.reading.find import find_file
from nrp_core.experiment.reading.yaml_tree import known_tree, read_tree
from nrp_core.findings import Code, Finding, InvalidExperimentError
from nrp_core.registry import Registry
from nrp_core.world.backends import worlds

F = TypeVar("F", bound=BaseModel)


def read_form(path: Path, form: type[F], what: str) -> tuple[F, Tree]:
    """Read a file.

    Args:
        path: the file.
        form: its keys and the types of their values.
        what: the whole file, in messages.

    Returns:
        its contents, and the file with the place of every value.

    Raises:
        InvalidExperimentError: it cannot be read or is not valid; the error carries all findings.
    """
    tree = read_form_tree(path, what)
    return form_of(tree, form, what), tree


def read_form_tree(path: Path, what: str) -> Tree:
    """Read a file without checking its keys; see :func:`read_form`."""
    try:
        return read_tree(path.resolve(), what)
    except ExperimentError as error:
        raise InvalidExperimentError([Finding.of(error, Code.NRP200)]) from error


def form_of(tree: Tree, form: type[F], what: str) -> F:
    """Return the contents of a tree.

    Raises:
        InvalidExperimentError: it is not valid; the error carries all findings.
    """
    try:
        return form.model_validate(tree.plain())
    except ValidationError as error:
        raise InvalidExperimentError(schema_findings(error, form, tree, what=what)) from None


@dataclass(frozen=True, slots=True)
class Platform:
    """The object of an entry point in ``nrp_core.platforms``, which has the platform's name in experiments.

    Args:
        options: the class of its options in an experiment.
        maker: returns the maker of the parts of an experiment, given these options.
        described: returns the experiment that a document of the platform describes, if it is one; it gets
            the file and overrides.
    """

    options: type[Section]
    maker: Callable[[Experiment, Any], PartMaker]
    described: Callable[[Path, Sequence[str]], Experiment | None] | None = None


PLATFORMS: Registry[Platform] = Registry("nrp_core.platforms", "platform")


def with_platform(experiment: Experiment) -> Experiment:
    """Return an experiment with the maker of its platform, if it names one.

    Raises:
        InvalidExperimentError: the platform is not installed, or its options are wrong.
    """
    section = experiment.compatibility
    if section is None:
        return experiment
    try:
        platform = PLATFORMS.load(section.platform)
        options = platform.options.model_validate(section.options)
    except BackendError as error:
        place = experiment.place("compatibility", "platform")
        raise InvalidExperimentError([place.finding(Code.NRP205, str(error))]) from error
    except ValidationError as error:
        above = "compatibility", "options"
        raise InvalidExperimentError(
            schema_findings(error, platform.options, experiment.source, above, Code.NRP202)
        ) from None
    return experiment.with_maker(platform.maker(experiment, options))


def described_by(path: Path, overrides: Sequence[str] = ()) -> Experiment | None:
    """Return the experiment that a file describes, which names a brain or a body in addition to functions.

    Raises:
        InvalidExperimentError: it belongs to a platform, and cannot be read.
    """
    for name in PLATFORMS.names():
        platform = PLATFORMS.load(name)
        found = None if platform.described is None else platform.described(path, overrides)
        if found is not None:
            return found
    return None


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
            replaces. A file that several extend is merged once, first. Descriptions are not inherited.
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
    """Refuse a sweep, a search and a misspelt ``extends``, before all the keys that they lack are listed.

    Raises:
        InvalidExperimentError: it is one.
    """
    if isinstance(tree.value, dict) and {"experiment", "vary"} <= tree.value.keys():
        command = "evolve" if "objective" in tree.value else "sweep"
        message = f"this file names an experiment and varies it: use nrp {command}"
        raise InvalidExperimentError([tree.place.finding(Code.NRP201, message)])
    known = (*Experiment.model_fields, EXTENDS)
    for name in tree.value.keys() - known if isinstance(tree.value, dict) else ():
        if f"'{EXTENDS}'" in (hint := did_you_mean(str(name), known)):
            place = tree.value[name].key_place or tree.place
            raise InvalidExperimentError(
                [place.finding(Code.NRP201, f"an experiment has no key '{name}'{hint}")]
            )


def _laid_over(tree: Tree, over: Tree) -> Tree:
    """Return a file merged over the files that it extends; each of its values must change something."""
    _require_effect(tree, over)
    return tree.merged(over)


def _require_effect(below: Tree, above: Tree) -> None:
    """Refuse keys that are removed and do not exist, and empty mappings, which remove nothing.

    Raises:
        InvalidExperimentError: one was found.
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
    if extending:
        own.pop("description", None)  # it describes only this experiment, not those that extend it
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
            raise InvalidExperimentError([base.place.finding(Code.NRP200, message)])
    return bases


def _base(base: Tree, extending: tuple[Path, ...]) -> Path:
    try:
        if not isinstance(base.value, str):
            raise ExperimentError(f"'{EXTENDS}' takes files or names of experiments, one or a list")
        path = find_file(base.value, base.place.folder)
    except ExperimentError as error:
        raise InvalidExperimentError([base.place.finding(Code.NRP200, str(error))]) from error
    if path in extending:
        round_trip = " -> ".join(file.name for file in (*extending[extending.index(path) :], path))
        message = f"an experiment cannot extend itself: {round_trip}"
        raise InvalidExperimentError([base.place.finding(Code.NRP200, message)])
    return path


def overridden(tree: Tree, override: str) -> Tree:
    """Return a tree with one ``dotted.key=value`` applied, the value in YAML.

    Raises:
        InvalidExperimentError: it cannot be applied.
    """
    place = Place(override=str(override))  # a value that is not a text cannot be read as one either
    key, equals, text = str(override).partition("=")
    keys = key.strip().split(".")
    try:
        if not equals or not all(keys):
            raise place.error("it must read 'dotted.key=value'")
        if not text.strip():
            _require_optional(tree, keys, place)
            raise place.error(f"there is no value; write '{key.strip()}=null' to remove it")
        value = known_tree(text, place)
        if value.value is None:
            _require_optional(tree, keys, place)
        _require_event(tree, keys, place)
        if (old := tree.at(*keys)) is not None and _is_idle(old, value):
            raise place.error(f"it changes nothing: mappings are merged; '{key.strip()}=null' removes it")
        return tree.overridden(keys, value)
    except ExperimentError as error:
        raise InvalidExperimentError([Finding.of(error, Code.NRP202)]) from error


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
        ExperimentError: the event does not exist.
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


DIALECT = "https://json-schema.org/draft/2020-12/schema"


def experiment_schema() -> dict[str, Any]:
    """Return the JSON Schema, with the options of every installed backend that loads.

    A file that extends another may omit the other's keys, so keys below the top level are not required,
    and ``null`` is allowed, which removes a key.
    """
    schema = {"$schema": DIALECT, **Experiment.model_json_schema()}
    extends = {
        "type": ["string", "array"],
        "items": {"type": "string"},
        "description": "The experiments that this one extends: a file or name, or a list of these.",
    }
    schema["properties"] = {EXTENDS: extends, **schema["properties"]}
    required = schema["required"]
    definitions = schema["$defs"]
    for section in (schema, *definitions.values()):
        _allow_removal(section, section.pop("required", ()))
    schema["anyOf"] = [{"required": [EXTENDS]}, {"required": required}]
    for model, registry in ((BrainSection, brains()), (WorldSection, worlds())):
        _add_backends(model, registry, definitions)
    return schema


def _allow_removal(section: dict[str, Any], required: Container[str]) -> None:
    """Allow ``null`` for every key that can be missing, and for every name below one."""
    for key, value in section.get("properties", {}).items():
        if key not in required:
            _allow_null(value)
        for pattern, named in value.get("patternProperties", {}).items():
            value["patternProperties"][pattern] = {"anyOf": [named, {"type": "null"}]}


def _allow_null(value: dict[str, Any]) -> None:
    if "type" in value:
        types = value["type"] if isinstance(value["type"], list) else [value["type"]]
        value["type"] = [*types, "null"]
    if "enum" in value:
        value["enum"] = [*value["enum"], None]
    if "anyOf" in value:
        value["anyOf"] = [*value["anyOf"], {"type": "null"}]


def _add_backends(model: type[BaseModel], registry: Registry[Any], definitions: dict[str, Any]) -> None:
    """Describe the options of each backend if it is selected."""
    section = definitions[model.__name__]
    choices = section["properties"]["backend"]
    choices["anyOf"] = [{"enum": registry.names()}, {"type": choices.pop("type")}]
    section["allOf"] = []
    for name in registry.names():
        try:
            options = registry.load(name).options
        except BackendError:
            continue
        prefix = f"{model.__name__}.{name}."
        described = options.model_json_schema(ref_template=f"#/$defs/{prefix}{{model}}")
        definitions |= {prefix + key: value for key, value in described.pop("$defs", {}).items()}
        chosen = {"properties": {"backend": {"const": name}}, "required": ["backend"]}
        section["allOf"].append({"if": chosen, "then": {"properties": {"options": described}}})
