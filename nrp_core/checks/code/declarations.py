"""The transfer functions that a file declares, read without executing it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from nrp_core.checks.code.expressions import assigned
from nrp_core.checks.code.imports import Imports
from nrp_core.checks.code.shapes import (
    UNKNOWN,
    Call,
    Event,
    ImportsOf,
    Index,
    Known,
    Names,
    Read,
    Shape,
    missing_name,
)
from nrp_core.checks.code.statements import FAILURES, MisfitError, Statements, Written, changed_in
from nrp_core.checks.code.syntax import SCOPES, own_nodes
from nrp_core.dsl.device_kinds import DeviceKind
from nrp_core.dsl.functions import TIME, Neuron2Robot, Robot2Neuron, TransferFunction
from nrp_core.dsl.loading import Listing, PythonSource
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource, MapVariable
from nrp_core.dsl.parameters import Adapter, Binding, ParameterMapping, PreprocessedTopic
from nrp_core.dsl.selection import Selector
from nrp_core.errors import CapabilityError, ExperimentError, Instead, TopicError
from nrp_core.findings import Code, Finding, Level
from nrp_core.findings.error_codes import code_of

Function = ast.FunctionDef | ast.AsyncFunctionDef


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
        imports: returns the names that an import in its body binds.
        is_read: whether all of its decorators are understood.
        is_named: whether its name is known: a decorator or a statement of the file may have changed it.
        adapters: the adapters of its parameters, after binding.

    Attributes:
        own: the nodes of its body, last first, without the bodies of functions and classes in it.
    """

    function: TransferFunction
    node: Function
    source: PythonSource
    names: dict[str, Shape]
    nodes: dict[str, ast.expr]
    imports: ImportsOf
    is_read: bool = True
    is_named: bool = True
    adapters: dict[str, Adapter] = field(default_factory=dict)
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


def stub_of(node: Function, path: Path) -> Any:
    """Return a function with the same parameters and an empty body."""
    yields = any(isinstance(one, (ast.Yield, ast.YieldFrom)) for one in own_nodes(node.body))
    body = ast.Expr(ast.Yield(None)) if yields else ast.Pass()
    parameters = ast.arguments(
        posonlyargs=[ast.arg(one.arg) for one in node.args.posonlyargs],
        args=[ast.arg(one.arg) for one in node.args.args],
        vararg=ast.arg(node.args.vararg.arg) if node.args.vararg else None,
        kwonlyargs=[ast.arg(one.arg) for one in node.args.kwonlyargs],
        kw_defaults=[None for _ in node.args.kwonlyargs],
        kwarg=ast.arg(node.args.kwarg.arg) if node.args.kwarg else None,
        defaults=[],
    )
    stub = type(node)(node.name, parameters, [body], [])
    for part in ast.walk(stub):
        ast.copy_location(part, node)
    names: dict[str, Any] = {"__builtins__": {}}
    exec(compile(ast.Module([stub], []), str(path), "exec"), names)
    return names[node.name]


def used_functions(declared: Declared) -> Iterator[Function]:
    """Yield a transfer function, and the functions of its file that it calls, directly or through others."""
    written = {
        node.name: node
        for node in own_nodes(declared.source.tree.body)
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and not node.decorator_list
    }
    waiting: list[Function] = [declared.node]
    while waiting:
        function = waiting.pop()
        yield function
        named = {node.id for node in ast.walk(function) if isinstance(node, ast.Name)}
        waiting += [written.pop(name) for name in sorted(named & set(written) - local_names(function))]


def local_names(function: Function) -> set[str]:
    """Return the parameters of a function and the names that it assigns, with those of functions in it."""
    found: set[str] = set()
    shared: set[str] = set()
    for node in ast.walk(function):
        match node:
            case ast.arg(name):
                found.add(name)
            case ast.FunctionDef(name=name, body=body) | ast.AsyncFunctionDef(name=name, body=body):
                found |= assigned(body) if node is function else {name, *assigned(body)}
            case ast.Global(names) | ast.Nonlocal(names):
                shared.update(names)
    return found - shared


def root_of(node: ast.expr) -> ast.expr:
    """Return the innermost object of attributes and items: ``a`` of ``a.b[0].c``."""
    while isinstance(node, (ast.Attribute, ast.Subscript)):
        node = node.value
    return node


_FUNCTION_DECORATORS = (Neuron2Robot, Robot2Neuron)
_NO_TOPIC = (MapSpikeSink, MapSpikeSource, MapVariable)


class Declarations(Statements):
    """Reads the declarations of a listing.

    Args:
        listing: the listing.

    Attributes:
        functions: the declared transfer functions.
        findings: the mistakes in their declarations.
        slices: for each choice of neurons by a slice: its place, the population and the slice.
        is_complete: whether all declarations could be read.
    """

    def __init__(self, listing: Listing) -> None:
        framework = listing.names.get("nrp")
        ours = [value for value in vars(framework).values() if callable(value)] if framework else []
        ours += [listing.names[name] for name in ("Topic",) if name in listing.names]
        changed = {name for source in listing.sources for name in changed_in(source.tree)}
        super().__init__({name: Known(value) for name, value in listing.names.items()}, ours, Path(), changed)
        self.divide = listing.divide
        self.functions: list[Declared] = []
        self.findings: list[Finding] = []
        self.slices: list[tuple[PythonSource, ast.expr, Selector, slice]] = []
        self.is_complete = True
        self._is_wrong = False
        self._is_read = True
        self._reached: set[int] = set()
        self._imports = Imports(listing)
        for self._source in listing.sources:
            self.path = self._source.path
            self.follow_file(self._source.tree.body)
        for self._source in listing.sources:
            self._note_not_followed()
            self._find_unreached()
        self.findings += (Finding.of(error, Code.NRP218) for error in self._imports.neighbours.errors)
        for function in self.functions:
            function.names = {**self.names, **dict.fromkeys(changed, UNKNOWN), **function.names}

    @property
    def neighbours(self) -> list[PythonSource]:
        """The modules beside its files, as far as they are imported."""
        return list(self._imports.neighbours.sources.values())

    # -- statements of the file

    def statement(self, node: ast.stmt) -> None:
        match node:
            case ast.Import() | ast.ImportFrom():
                self._import(node)
            case ast.FunctionDef(decorator_list=[_, *_]) | ast.AsyncFunctionDef(decorator_list=[_, *_]):
                self._reached.add(id(node))
                made = self._function(node)
                self.names[node.name] = UNKNOWN if made is None else Known(made.function)
                self.functions += [] if made is None else [made]
            case _:
                super().statement(node)

    def bind(self, target: ast.expr, shape: Shape) -> None:
        match target, shape:
            case ast.Attribute(value, ("priority" | "active" | "name") as name), _:
                self._settle(self.shape(value), name, shape)
            case _:
                super().bind(target, shape)

    def _settle(self, owner: Shape, name: str, shape: Shape) -> None:
        """Apply a statement that sets an attribute of a transfer function."""
        made = owner.value if isinstance(owner, Known) else None
        if isinstance(made, TransferFunction) and isinstance(shape, Known):
            setattr(made, name, shape.value)
        for declared in self.functions:
            if name == "name" and declared.function is made and not isinstance(shape, Known):
                declared.is_named = False

    def _import(self, node: ast.Import | ast.ImportFrom) -> None:
        for imported in self._imports.of(node, self.path):
            self.names[imported.name] = imported.shape
            if imported.wrong:
                self.findings.append(found_in(self._source, Code.NRP218, node, imported.wrong))

    def skip(self, node: ast.stmt) -> None:
        self._note_declared(node)
        super().skip(node)

    def _note_not_followed(self) -> None:
        """Note the declarations inside functions whose calls could not be followed."""
        within = set(map(id, ast.walk(self._source.tree)))
        for written in self.written:
            if id(written.node) in within and not written.is_followed:
                self._note_declared(written.node)

    def _note_declared(self, node: ast.AST) -> None:
        """Report the transfer functions that are declared in code that is not followed."""
        for one in ast.walk(node):
            called = self.names.get(one.id) if isinstance(one, ast.Name) else None
            if isinstance(called, Known) and isinstance(called.value, Written):
                called.value.is_lost = True
            if isinstance(one, (ast.FunctionDef, ast.AsyncFunctionDef)) and any(
                map(self._is_declaration, one.decorator_list)
            ):
                self._reached.add(id(one))
                self._note(one, f"'{one.name}' is declared only when the file is executed")

    def _find_unreached(self) -> None:
        """Look for declarations in branches that are never taken, and after a ``return``."""
        declared = {function.node.name for function in self.functions}
        followed = {id(written.node): written.is_followed for written in self.written}
        waiting: list[tuple[ast.AST, Level]] = [(one, Level.WARNING) for one in self._source.tree.body]
        while waiting:
            node, level = waiting.pop(0)
            if id(node) in self._reached:
                continue
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and any(
                map(self._is_declaration, node.decorator_list)
            ):
                if node.name not in declared:
                    message = f"'{node.name}' is not registered: this code is never reached"
                    self.findings.append(found_in(self._source, Code.NRP210, node, message, level))
            elif isinstance(node, SCOPES) and id(node) not in followed:
                self._note_declared(node)
            elif followed.get(id(node), True):  # another one is reported already
                inner = (one for one in ast.iter_child_nodes(node) if not isinstance(one, ast.expr))
                waiting += ((one, _level_in(node, level)) for one in inner)

    def _is_declaration(self, decorator: ast.expr) -> bool:
        found = self.quietly(decorator.func if isinstance(decorator, ast.Call) else decorator)
        return isinstance(found, Known) and self.is_ours(found.value)

    def _note(self, node: ast.AST, message: str) -> None:
        self.is_complete = False
        if not self._is_wrong:
            self.findings.append(found_in(self._source, Code.NRP239, node, message, Level.NOTE))

    # -- declarations

    def _function(self, node: Function) -> Declared | None:
        before = len(self.findings)
        self._is_read = True
        decorators = [(one, self._decorator(one)) for one in node.decorator_list]
        made = [(one, value) for one, value in decorators if value is not None]
        if not made:
            if len(self.findings) > before:
                self.is_complete = False
            return None
        if [argument.arg for argument in node.args.args][:1] != [TIME]:
            first = node.args.args[0] if node.args.args else node
            message = f"the first parameter of transfer function '{node.name}' must be the time, '{TIME}'"
            self.findings.append(found_in(self._source, Code.NRP219, first, message))
            self.is_complete = False
            return None
        declared = Declared(stub_of(node, self.path), node, self._source, self.local, {}, self._imports.of)
        others = [one for one, value in decorators if value is None]
        declared.is_read = self._is_read and all(map(self._keeps_it, others))
        declared.is_named = not others
        for one, value in reversed(made):
            if not self._apply(declared, one, value):
                self.is_complete = False
                return None
        if not any(found.code is Code.NRP219 for found in self.findings[before:]):
            self.findings += _unmapped(declared)
        return declared

    def observe(self, event: Event) -> None:
        match event:
            case Index(node, Known(value), Known(slice() as index)) if isinstance(value, Selector):
                self.slices.append((self._source, node, value, index))
            case Read(node, Known(ModuleType()) | Names(), _, False):
                self._is_wrong = True
                message, instead = missing_name(event)
                self.findings.append(found_in(self._source, Code.NRP240, node, message, instead=instead))

    def _decorator(self, node: ast.expr) -> Any:
        """Return the object that a decorator names; None if it is unknown or not one of ours."""
        self._is_wrong = False
        try:
            found = self.shape(node)
        except ExperimentError as error:
            self._refuse(node, error)
            return self._substitute_of(node)
        except CapabilityError as error:
            self.findings.append(found_in(self._source, Code.NRP216, node, str(error)))
            return self._substitute_of(node)
        except FAILURES as error:
            message = str(error) if isinstance(error, MisfitError) else f"not possible: {error}"
            self.findings.append(found_in(self._source, Code.NRP240, node, message))
            return self._substitute_of(node)
        value = found.value if isinstance(found, Known) else None
        if isinstance(value, (ParameterMapping, *_FUNCTION_DECORATORS)):
            return value
        if isinstance(value, type) and issubclass(value, (ParameterMapping, *_FUNCTION_DECORATORS)):
            is_mapping = issubclass(value, ParameterMapping)
            arguments = "(...)" if is_mapping else "()"
            message = f"'@nrp.{value.__name__}' must be called: @nrp.{value.__name__}{arguments}"
            self.findings.append(found_in(self._source, Code.NRP210, node, message))
            self._is_read &= not is_mapping  # its parameter is unknown
            return None if is_mapping else self._plain(value)
        return None

    def _keeps_it(self, node: ast.expr) -> bool:
        """Return whether a decorator of the user returns the function that it is given."""
        found = self.quietly(node)
        return isinstance(found, Known) and isinstance(found.value, Written) and _returns_its_own(found.value)

    def _substitute_of(self, node: ast.expr) -> Any:
        """Return a substitute for a refused decorator, so that the rest is still checked."""
        if not isinstance(node, ast.Call):
            return None
        callee = self.quietly(node.func)
        kind = callee.value if isinstance(callee, Known) else None
        if isinstance(kind, type) and issubclass(kind, _FUNCTION_DECORATORS):
            return self._plain(kind)
        first = node.args[0] if node.args else next((k.value for k in node.keywords if k.arg == "key"), None)
        name = self.quietly(first) if first is not None else UNKNOWN
        if isinstance(name, Known) and isinstance(name.value, str):
            return self.at(node, Unread, name.value)
        return None

    @staticmethod
    def _plain(kind: type[Any]) -> Any:
        return Robot2Neuron() if issubclass(kind, Robot2Neuron) else Neuron2Robot()

    def called_in_part(self, call: Call) -> Shape:
        kind = call.callee.value if isinstance(call.callee, Known) else None
        if not isinstance(kind, type):
            return UNKNOWN
        if issubclass(kind, MapVariable):
            named = {name: shape for name, shape in call.named.items() if name != "initial_value"}
            if len(named) < len(call.named) or len(call.given) >= 3:
                given = [*call.given[:2], *call.given[3:]] if len(call.given) >= 3 else call.given
                return self.called(Call(call.node, call.callee, tuple(given[:2]), named, call.is_whole))
        if issubclass(kind, PreprocessedTopic):
            return self._topic(call)
        if issubclass(kind, (ParameterMapping, *_FUNCTION_DECORATORS)):
            was_complete = self.is_complete
            self._note(call.node, f"the arguments of {kind.__name__} are known only when it runs")
            if issubclass(kind, _NO_TOPIC):
                self.is_complete = was_complete
            self._is_read &= not issubclass(kind, _FUNCTION_DECORATORS)
            found = self._substitute_of(call.node)
            return UNKNOWN if found is None else Known(found)
        return UNKNOWN

    def _topic(self, call: Call) -> Shape:
        """Return a topic that is known except for the conversion of its messages."""
        given, named = list(call.given), dict(call.named)
        if len(given) > 2:
            given[2] = Known(_processed)
        elif "pre_processing" in named:
            named["pre_processing"] = Known(_processed)
        if UNKNOWN in (*given, *named.values()):
            return UNKNOWN
        return self.called(Call(call.node, call.callee, tuple(given), named, call.is_whole))

    def _refuse(self, node: ast.expr, error: ExperimentError) -> None:
        code = Code.NRP212 if isinstance(error, TopicError) else self._code_of(node)
        self.findings.append(found_in(self._source, code, node, error.message, instead=error.instead))

    def _code_of(self, node: ast.expr) -> Code:
        """Return the code of the mistake in a mapping to a device."""
        if not isinstance(node, ast.Call):
            return Code.NRP210
        callee = self.quietly(node.func)
        kinds = [found.value for found in map(self.quietly, [*node.args, *(k.value for k in node.keywords)])
                 if isinstance(found, Known) and isinstance(found.value, DeviceKind)]  # fmt: skip
        mapping = callee.value if isinstance(callee, Known) else None
        if not kinds or not isinstance(mapping, type):
            return Code.NRP210
        for side in (MapSpikeSink, MapSpikeSource):
            if issubclass(mapping, side):
                return Code.NRP240 if kinds[0].drives is side.drives else Code.NRP210
        return Code.NRP210

    def _apply(self, declared: Declared, node: ast.expr, decorator: Any) -> bool:
        """Apply a decorator to a function; return whether the result is still one."""
        try:
            declared.function = self.at(declared.node, decorator, declared.function)
        except ExperimentError as error:
            is_mapping = isinstance(decorator, ParameterMapping)
            code = code_of(error, Code.NRP219 if is_mapping else Code.NRP210)
            self.findings.append(found_in(self._source, code, node, error.message, instead=error.instead))
            return is_mapping and isinstance(declared.function, TransferFunction)
        name = decorator.parameter if isinstance(decorator, ParameterMapping) else ""
        declared.nodes[name] = node
        return True


def _returns_its_own(written: Written) -> bool:
    """Return whether a function returns its first argument, and calls nothing that could add a mapping."""
    first = next((one.arg for one in written.node.args.args), "")
    nodes = list(own_nodes(written.node.body))
    returns = [one.value for one in nodes if isinstance(one, ast.Return)]
    return (
        bool(returns)
        and all(isinstance(one, ast.Name) and one.id == first for one in returns)
        and first not in assigned(written.node.body)
        and not any(isinstance(one, ast.Call) for one in nodes)
    )


def _level_in(node: ast.AST, level: Level) -> Level:
    """Return the level of a declaration that is never reached: a setting in the file may choose it."""
    match node:
        case ast.If(test) | ast.For(iter=test) if not isinstance(test, ast.Constant):
            return Level.NOTE
    return level


def _processed(message: Any) -> Any:
    """Represent a function of the user."""
    return message


def _unmapped(declared: Declared) -> Iterator[Finding]:
    if not declared.is_read:
        return
    function = declared.function
    for name in function.parameters:
        if name not in function.mappings:
            message = f"nothing is mapped to the parameter '{name}' of transfer function '{function.name}'"
            yield declared.finding(Code.NRP219, declared.parameter(name), message)
