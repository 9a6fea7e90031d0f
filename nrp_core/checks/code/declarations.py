"""The transfer functions that a file declares, read without executing it."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from nrp_core.checks.code.imports import Imports
from nrp_core.checks.code.statements import FAILURES, MisfitError, Statements, changed_names
from nrp_core.checks.code.syntax import Function, own_nodes, stub_of
from nrp_core.checks.code.values import Known, Shape, has_attribute, names_of, value_of
from nrp_core.dsl.device_kinds import DeviceKind
from nrp_core.dsl.functions import TIME, Neuron2Robot, Robot2Neuron, TransferFunction
from nrp_core.dsl.loading import Listing, PythonSource
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource, MapVariable
from nrp_core.dsl.parameters import Adapter, Binding, ParameterMapping
from nrp_core.dsl.rewards import MapReward
from nrp_core.dsl.weights import MapWeights
from nrp_core.errors import CapabilityError, ExperimentError, Instead, TopicError, did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_core.findings.error_codes import code_of

_FUNCTION_DECORATORS: Final = (Neuron2Robot, Robot2Neuron)
_DECORATORS: Final = (ParameterMapping, *_FUNCTION_DECORATORS)
_WITHOUT_TOPIC: Final = (MapSpikeSink, MapSpikeSource, MapVariable, MapReward, MapWeights)
_REPLACEABLE: Final = ("initial_value", "pre_processing")
"""Arguments whose values no check needs."""


class Unread(ParameterMapping):
    """A mapping with an unknown target."""

    def __call__(self, function: Any) -> TransferFunction:
        """Return the transfer function with the mapping added."""
        made = function if isinstance(function, TransferFunction) else Robot2Neuron()(function)
        made.add(self)
        return made

    def _do_bind(self, binding: Binding) -> Adapter:
        return Adapter()

    def __str__(self) -> str:
        return "known only when it runs"


@dataclass(slots=True)
class Declared:
    """A transfer function as it is written.

    Args:
        function: the transfer function with an empty body.
        node: its syntax tree.
        source: the file.
        names: the shapes of the names that its body sees, parameters aside.
        nodes: the decorator of each mapping, and the function's own under an empty name.
        imports: the imports of its file.
        is_read: whether all of its decorators are understood.
        is_named: whether its name is known: a decorator or a statement of the file may have changed it.

    Attributes:
        own: the nodes of its body, last first, without the bodies of functions and classes in it.
    """

    function: TransferFunction
    node: Function
    source: PythonSource
    names: dict[str, Shape]
    nodes: dict[str, ast.expr]
    imports: Imports
    is_read: bool = True
    is_named: bool = True
    own: tuple[ast.AST, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.own = tuple(own_nodes(self.node.body))

    def finding(
        self,
        code: Code,
        node: ast.AST | None,
        message: str,
        level: Level = Level.ERROR,
        instead: Instead | None = None,
    ) -> Finding:
        """Return a finding about something in it."""
        return found_in(self.source, code, node or self.node, message, level, instead)

    def parameter(self, name: str) -> ast.arg:
        """Return the place of a parameter."""
        return next(one for one in self.node.args.args if one.arg == name)


def found_in(
    source: PythonSource,
    code: Code,
    node: ast.AST,
    message: str,
    level: Level = Level.ERROR,
    instead: Instead | None = None,
) -> Finding:
    """Return a finding about a node of a source."""
    line, column = getattr(node, "lineno", None), getattr(node, "col_offset", 0) + 1
    where = source.path, line, column if source.has_columns else None
    return Finding(code, message, level, *where, instead=instead)


_MAKERS = ("map_afferents", "map_motoneurons")
"""The statements of the framework that make functions, which are known only when they run."""


def _makes_functions(node: ast.AST) -> bool:
    return getattr(node, "attr", getattr(node, "id", "")) in _MAKERS


class _File(Statements):
    """Follows the statements and imports of a file, and collects the mistakes in them."""

    _imports: Imports
    _source: PythonSource
    findings: list[Finding]

    def statement(self, node: ast.stmt) -> None:
        if not isinstance(node, ast.Import | ast.ImportFrom):
            super().statement(node)
            return
        for imported in self._imports.of(node, self.path):
            self.names[imported.name] = imported.shape
            if imported.error:
                self._report(Code.NRP218, node, imported.error)

    def _report(
        self,
        code: Code,
        node: ast.AST,
        message: str,
        level: Level = Level.ERROR,
        instead: Instead | None = None,
    ) -> None:
        self.findings.append(found_in(self._source, code, node, message, level, instead))


class Declarations(_File):
    """Reads the declarations of a listing.

    Args:
        listing: the listing.

    Attributes:
        functions: the declared transfer functions.
        findings: the mistakes in their declarations.
        is_complete: whether all declarations could be read.
    """

    def __init__(self, listing: Listing) -> None:
        framework = listing.names.get("nrp")
        ours = [value for value in vars(framework).values() if callable(value)] if framework else []
        ours += [listing.names[name] for name in ("Topic",) if name in listing.names]
        changed = {name for source in listing.sources for name in changed_names(source.tree)}
        super().__init__({name: Known(value) for name, value in listing.names.items()}, ours, Path(), changed)
        self.divide = listing.divide
        self.functions: list[Declared] = []
        self.findings = []
        self.is_complete = True
        self._is_read = True
        self._reached: set[int] = set()
        self._imports = Imports(listing, self._names_of_module)
        nodes = [node for source in listing.sources for node in ast.walk(source.tree)]
        self._set_attributes = [
            one.attr for one in nodes if isinstance(one, ast.Attribute) and isinstance(one.ctx, ast.Store)
        ]
        for self._source in listing.sources:
            self.path = self._source.path
            self.follow_file(self._source.tree.body)
        for self._source in listing.sources:
            self._note_unreached()
            self.is_complete &= not any(map(_makes_functions, ast.walk(self._source.tree)))
        self.findings += (Finding.of(error, Code.NRP218) for error in self._imports.errors)
        for function in self.functions:
            function.names = {**self.names, **dict.fromkeys(changed), **function.names}

    @property
    def neighbours(self) -> list[PythonSource]:
        """The modules beside its files, as far as they are imported."""
        return list(self._imports.sources.values())

    # -- statements of the file

    def statement(self, node: ast.stmt) -> None:
        match node:
            case ast.FunctionDef(decorator_list=[_, *_]) | ast.AsyncFunctionDef(decorator_list=[_, *_]):
                self._reached.add(id(node))
                made = self._function(node)
                self.names[node.name] = None if made is None else Known(made.function)
                self.functions += [] if made is None else [made]
            case _:
                super().statement(node)

    def bind(self, target: ast.expr, shape: Shape) -> None:
        match target:
            case ast.Attribute(value, ("priority" | "active" | "name") as name):
                self._set_attribute(self.quietly(value), name, shape)
            case _:
                super().bind(target, shape)

    def _set_attribute(self, owner: Shape, name: str, shape: Shape) -> None:
        """Apply a statement that sets an attribute of a transfer function."""
        made = value_of(owner, TransferFunction)
        if made is not None and isinstance(shape, Known):
            setattr(made, name, shape.value)
        elif name == "name":
            for declared in self.functions:
                declared.is_named &= declared.function is not made

    def _names_of_module(self, source: PythonSource) -> dict[str, Shape]:
        """Return the names of a module beside the file."""
        module = _Module(source, self._imports)
        self.findings += module.findings
        return {**module.names, **dict.fromkeys(self._set_attributes)}

    def _note_unreached(self) -> None:
        """Note the transfer functions that are declared in code that is not followed."""
        declared = {function.node.name for function in self.functions}
        for node in ast.walk(self._source.tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and id(node) not in self._reached:
                called = [one.func if isinstance(one, ast.Call) else one for one in node.decorator_list]
                is_ours = any(self.is_ours(value_of(self.quietly(one))) for one in called)
                if is_ours and node.name not in declared:
                    self._note(node, f"'{node.name}' is declared only when the file is executed")

    def _note(self, node: ast.AST, message: str) -> None:
        self.is_complete = False
        self._report(Code.NRP239, node, message, Level.NOTE)

    # -- declarations

    def _function(self, node: Function) -> Declared | None:
        before = len(self.findings)
        self._is_read = True
        decorators = [(one, self._decorator(one)) for one in node.decorator_list]
        made = [(one, value) for one, value in decorators if value is not None]
        if not made:
            self.is_complete &= len(self.findings) == before
            return None
        if [argument.arg for argument in node.args.args][:1] != [TIME]:
            first = node.args.args[0] if node.args.args else node
            message = f"the first parameter of transfer function '{node.name}' must be the time, '{TIME}'"
            self._report(Code.NRP219, first, message)
            self.is_complete = False
            return None
        declared = Declared(stub_of(node, self.path), node, self._source, self.local, {}, self._imports)
        declared.is_named = len(made) == len(decorators)
        declared.is_read = self._is_read and declared.is_named
        for one, value in reversed(made):
            if not self._apply(declared, one, value):
                self.is_complete = False
                return None
        if not any(found.code is Code.NRP219 for found in self.findings[before:]):
            self.findings += _unmapped(declared)
        return declared

    def _decorator(self, node: ast.expr) -> Any:
        """Return the object that a decorator names; None if it is unknown or not one of ours."""
        before = len(self.findings)
        self._report_missing_names(node)
        try:
            found = self.shape(node)
        except FAILURES as error:
            is_clear = isinstance(error, ExperimentError | MisfitError | CapabilityError)
            message = getattr(error, "message", str(error)) if is_clear else f"not possible: {error}"
            code = self._code_of(node) if isinstance(error, ExperimentError) else Code.NRP240
            if isinstance(error, TopicError | CapabilityError):
                code = code_of(error, code)
            self._report(code, node, message, instead=getattr(error, "instead", None))
            return self._substitute_of(node)
        if len(self.findings) > before:  # the note about unknown arguments only repeats it
            named = [one for one in self.findings[before:] if one.code is not Code.NRP239]
            self.findings[before:] = named or self.findings[before:]
        value = value_of(found, (*_DECORATORS, type))
        if not isinstance(value, type):
            return value
        if issubclass(value, _DECORATORS):
            is_mapping = issubclass(value, ParameterMapping)
            arguments = "(...)" if is_mapping else "()"
            message = f"'@nrp.{value.__name__}' must be called: @nrp.{value.__name__}{arguments}"
            self._report(Code.NRP210, node, message)
            self._is_read &= not is_mapping  # its parameter is unknown
            return None if is_mapping else _plain(value)
        return None

    def _report_missing_names(self, decorator: ast.expr) -> None:
        """Report the attributes of modules in a decorator that do not exist."""
        for node in ast.walk(decorator):
            if isinstance(node, ast.Attribute):
                owner = self.quietly(node.value)
                if value_of(owner, ModuleType) is not None and not has_attribute(owner, node.attr):
                    message, instead = missing_name(owner, node)
                    self._report(Code.NRP240, node, message, instead=instead)

    def _substitute_of(self, node: ast.expr) -> Any:
        """Return a substitute for a refused decorator, so that the rest is still checked."""
        if not isinstance(node, ast.Call):
            return None
        kind = value_of(self.quietly(node.func), type)
        if kind is not None and issubclass(kind, _FUNCTION_DECORATORS):
            return _plain(kind)
        first = node.args[0] if node.args else next((k.value for k in node.keywords if k.arg == "key"), None)
        name = value_of(self.quietly(first), str)
        return None if name is None else self.call_at(node, Unread, name)

    def call_in_part(self, node: ast.Call, called: Any, given: list[Shape], named: dict[str, Shape]) -> Shape:
        if not isinstance(called, type):
            return None
        filled = {
            name: Known(_unchanged) if shape is None and name in _REPLACEABLE else shape
            for name, shape in (
                *zip(inspect.signature(called).parameters, given, strict=False),
                *named.items(),
            )
        }
        if all(isinstance(one, Known) for one in filled.values()):
            return self._called(node, called, [], filled)
        if not issubclass(called, _DECORATORS):
            return None
        was_complete = self.is_complete
        self._note(node, f"the arguments of {called.__name__} are known only when it runs")
        if issubclass(called, _WITHOUT_TOPIC):
            self.is_complete = was_complete
        self._is_read &= not issubclass(called, _FUNCTION_DECORATORS)
        found = self._substitute_of(node)
        return None if found is None else Known(found)

    def _code_of(self, node: ast.expr) -> Code:
        """Return the code of a mistake in a mapping: if its device fits, a setting is wrong."""
        if not isinstance(node, ast.Call):
            return Code.NRP210
        mapping = value_of(self.quietly(node.func), type)
        given = [self.quietly(one) for one in (*node.args, *(each.value for each in node.keywords))]
        sides = [one.drives for one in (value_of(each, DeviceKind) for each in given) if one is not None]
        is_device = mapping is not None and issubclass(mapping, MapSpikeSink | MapSpikeSource)
        return Code.NRP240 if is_device and sides[:1] == [mapping.drives] else Code.NRP210

    def _apply(self, declared: Declared, node: ast.expr, decorator: Any) -> bool:
        """Apply a decorator to a function; return whether the result is still one."""
        is_mapping = isinstance(decorator, ParameterMapping)
        try:
            declared.function = self.call_at(declared.node, decorator, declared.function)
        except ExperimentError as error:
            code = code_of(error, Code.NRP219 if is_mapping else Code.NRP210)
            self._report(code, node, error.message, instead=error.instead)
            return is_mapping and isinstance(declared.function, TransferFunction)
        declared.nodes[decorator.parameter if is_mapping else ""] = node
        return True


class _Module(_File):
    """Reads a module beside a file.

    Args:
        source: its source.
        imports: the imports.

    Attributes:
        findings: the mistakes found.
    """

    def __init__(self, source: PythonSource, imports: Imports) -> None:
        super().__init__({}, (), source.path, changed_names(source.tree))
        self._imports, self._source = imports, source
        self.findings = []
        for node in ast.walk(source.tree):  # names set in branches and functions may exist, too
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                self.names[node.id] = None
        self.follow_file(source.tree.body)


def missing_name(owner: Shape, node: ast.Attribute) -> tuple[str, Instead | None]:
    """Return the message for a name that a module does not have, and what to replace it with."""
    hint = did_you_mean(node.attr, names_of(owner))
    return f"'{ast.unparse(node.value)}' has no '{node.attr}'{hint}", hint.instead


def _plain(kind: type[Any]) -> Any:
    return Robot2Neuron() if issubclass(kind, Robot2Neuron) else Neuron2Robot()


def _unchanged(message: Any) -> Any:
    """Represent a function of the user."""
    return message


def _unmapped(declared: Declared) -> Iterator[Finding]:
    function = declared.function
    for name in function.parameters if declared.is_read else ():
        if name not in function.mappings:
            message = f"nothing is mapped to the parameter '{name}' of transfer function '{function.name}'"
            yield declared.finding(Code.NRP219, declared.parameter(name), message)
