"""Collect mistakes of an experiment with their places, pydantic's included, and continue."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from nrp_core.errors import BackendError, CapabilityError, ExperimentError, did_you_mean
from nrp_core.experiment.model.section import Key, Tree
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level, has_errors
from nrp_core.findings.error_codes import code_of
from nrp_core.paths import MissingFileError


def schema_findings(
    error: ValidationError,
    model: type[BaseModel],
    tree: Tree,
    above: Sequence[Key] = (),
    code: Code | None = None,
    what: str = "an experiment",
) -> list[Finding]:
    """Turn the errors of a validation into findings.

    Args:
        error: pydantic's error.
        model: the validated class.
        tree: the whole file.
        above: the keys of the validated data in the file.
        code: the code of all findings, instead of those for a schema.
        what: the whole file, in messages.
    """
    found: dict[tuple[Key, ...], Finding] = {}
    for detail in error.errors():
        finding, keys = _finding(detail, model, tree, above, what)
        if keys in found:  # every member of a union has its own error
            finding = replace(found[keys], message=f"{found[keys].message}, or {describe_fault(detail)}")
        found[keys] = finding
    return [replace(finding, code=code or finding.code) for finding in found.values()]


def _finding(
    detail: ErrorDetails, model: type[BaseModel], tree: Tree, above: Sequence[Key], whole: str
) -> tuple[Finding, tuple[Key, ...]]:
    """Return a finding and its subject; two findings about the same subject are merged."""
    named = detail["loc"] or _leading_keys(detail)
    reached, keys = tree.nearest([*above, *named])
    last, what = detail["loc"][-1] if detail["loc"] else "", _join_keys(keys)
    if detail["type"] == "extra_forbidden":
        section = f"'{_join_keys(keys[:-1])}'" if len(keys) > 1 else whole
        hint = did_you_mean(str(last), keys_at(model.model_json_schema(), keys[len(above) : -1]))
        message = f"{section} has no key '{last}'{hint}"
        return (reached.key_place or reached.place).finding(Code.NRP201, message), keys
    if detail["type"] == "missing":
        thing = f"value {last + 1}" if isinstance(last, int) else f"the key '{last}'"
        section = f"'{what}'" if what else whole
        return reached.place.finding(Code.NRP201, f"{section} needs {thing}"), (*keys, last)
    cause = detail.get("ctx", {}).get("error")
    code = Code.NRP204 if isinstance(cause, MissingFileError) else Code.NRP202
    message = f"{what}: {describe_fault(detail)}" if what and detail["loc"] else describe_fault(detail)
    if last == "[key]":
        return (reached.key_place or reached.place).finding(code, message), (*keys, last)
    return reached.place.finding(code, message), keys


def _leading_keys(detail: ErrorDetails) -> tuple[str, ...]:
    """Return the keys that the message about a whole file begins with, as in ``vary.seed: ...``."""
    if detail["type"] != "value_error":
        return ()
    section, _, key = describe_fault(detail).partition(":")[0].partition(".")
    return (section, key) if key else (section,)


_KINDS = {
    "bool": "a valid boolean", "int": "a valid integer", "float": "a valid number",
    "string": "a valid string", "path": "a valid path", "list": "a valid list", "tuple": "a valid list",
    "set": "a valid list", "dict": "a valid mapping", "mapping": "a valid mapping",
    "model": "a valid mapping",
}  # fmt: skip
_RULES = {
    "int_from_float": "should be a valid integer",
    "finite_number": "should be a finite number",
    "greater_than": "should be greater than {gt:g}",
    "greater_than_equal": "should be greater than or equal to {ge:g}",
    "less_than": "should be less than {lt:g}",
    "less_than_equal": "should be less than or equal to {le:g}",
    "multiple_of": "should be a multiple of {multiple_of:g}",
    "too_short": "should have at least {min_length} items",
    "too_long": "should have at most {max_length} items",
    "string_too_short": "should have at least {min_length} characters",
    "string_too_long": "should have at most {max_length} characters",
    "enum": "should be {expected}",
    "literal_error": "should be {expected}",
}
_RULES |= {
    f"{kind}_{error}": f"should be {named}" for kind, named in _KINDS.items() for error in ("type", "parsing")
}
"""The rule that a value breaks, by the type of pydantic's error; names in braces are in its context."""


def describe_fault(detail: ErrorDetails) -> str:
    """Return a description of a mistake in a value, without pydantic's terms."""
    context = detail.get("ctx", {})
    if detail["type"] == "value_error":
        return str(context["error"])
    rule = _RULES.get(detail["type"])
    return f"{rule.format(**context) if rule else detail['msg']}, not {detail['input']!r:.60}"


def _join_keys(keys: Sequence[Key]) -> str:
    return ".".join(map(str, keys))


def keys_at(schema: dict[str, Any], keys: Sequence[Key]) -> set[str]:
    """Return the keys that a JSON Schema defines at a place."""
    nodes = [schema]
    for key in keys:
        nodes = [child for node in nodes for plain in _plain(schema, node) for child in _below(plain, key)]
    return {name for node in nodes for plain in _plain(schema, node) for name in plain.get("properties", {})}


def _plain(schema: dict[str, Any], node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Follow references and alternatives."""
    if "$ref" in node:
        yield from _plain(schema, schema["$defs"][node["$ref"].rpartition("/")[2]])
    for kind in ("anyOf", "oneOf", "allOf"):
        for part in node.get(kind, ()):
            yield from _plain(schema, part)
    yield node


def _below(node: dict[str, Any], key: Key) -> Iterator[dict[str, Any]]:
    if isinstance(key, int):
        children = [node.get("items")]
    elif key in node.get("properties", {}):
        children = [node["properties"][key]]
    else:
        children = [node.get("additionalProperties"), *node.get("patternProperties", {}).values()]
    yield from (child for child in children if isinstance(child, dict))


_MILD = {Code.NRP239: Level.WARNING}


@dataclass(frozen=True, slots=True)
class Omission:
    """A part that a lenient experiment omits.

    Args:
        code: the code of the finding about it.
        kind: the kind of part, such as ``robot``.
        name: the name of the part; None: it does not have one.
    """

    code: Code
    kind: str
    name: str | None = None

    def finding(self, cause: Finding) -> Finding:
        """Return the finding about the part that is omitted for a cause."""
        part = f"a {self.kind}" if self.name is None else f"the {self.kind} '{self.name}'"
        message = f"{part} is left out: {cause.message}"
        return replace(cause, code=self.code, message=message, level=Level.WARNING, subject=self.name)


class Collector:
    """Turns errors into findings.

    Args:
        source: the experiment as written, with the places.

    Attributes:
        source: the same.
        findings: the findings so far.
    """

    def __init__(self, source: Tree) -> None:
        self.source = source
        self._backend_error: BackendError | None = None
        self.findings: list[Finding] = []

    @contextmanager
    def during(
        self,
        code: Code,
        *keys: Key,
        level: Level = Level.ERROR,
        omission: Omission | None = None,
        always: bool = False,
    ) -> Iterator[None]:
        """Collect an error in this block instead of raising it.

        Args:
            code: the code of the finding, unless the class of the error has its own.
            keys: its place in the experiment; an error with a place keeps its own.
            level: its level.
            omission: the part to omit after an error; None: an error is only reported.
            always: whether errors of every class get the code.
        """
        try:
            yield
        except InvalidExperimentError as error:
            self.findings += error.findings
        except (BackendError, CapabilityError, ExperimentError) as error:
            known = code if always else code_of(error, code)
            level = _MILD.get(known, level)
            if isinstance(error, ExperimentError) and error.path is not None:
                finding = replace(Finding.of(error, known), level=level)
            else:
                finding = self.source.place_of(*keys).finding(known, str(error), level)
            if omission is not None:
                finding = omission.finding(finding)
            self.findings.append(finding)
            if (
                finding.level is Level.ERROR
                and isinstance(error, BackendError)
                and self._backend_error is None
            ):
                located = self.source.place_of(*keys).finding(known, error.reason).as_error()
                self._backend_error = type(error)(str(located), remedy=error.remedy)

    def add(
        self,
        code: Code,
        message: str,
        *keys: Key,
        level: Level = Level.ERROR,
        subject: str | None = None,
    ) -> None:
        """Add a finding at a place of the experiment."""
        found = self.source.place_of(*keys).finding(code, message, level)
        self.findings.append(replace(found, subject=subject))

    def place(self, findings: Iterable[Finding], *keys: Key) -> None:
        """Add findings; those without a place get one of the experiment."""
        where = self.source.place_of(*keys)
        self.findings += (
            found
            if found.path is not None
            else replace(found, path=where.path, line=where.line, column=where.column)
            for found in findings
        )

    def raise_errors(self) -> None:
        """Raise the mistakes that prevent a run, if any.

        Raises:
            BackendError: a backend is missing or broken.
            InvalidExperimentError: anything else is wrong; it carries all findings.
        """
        if self._backend_error is not None:
            raise self._backend_error
        if has_errors(self.findings):
            raise InvalidExperimentError(self.findings)
