"""The transfer functions that Python code declares, as far as they can be read without executing it.

Decorators with constants, selectors and names that a file sets once are understood; of anything else the text
is shown.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, NoReturn

from nrp_core.dsl.device_kinds import DeviceKind
from nrp_core.dsl.functions import TIME, Neuron2Robot, Robot2Neuron, TransferFunction
from nrp_core.dsl.loading import Listing, PythonSource
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.monitors import NeuronMonitor
from nrp_core.dsl.parameters import Adapter, Binding, ParameterMapping, SourceLine
from nrp_core.dsl.rewards import MapReward
from nrp_core.dsl.selection import BrainRoot, ProjectionSelector, Selection, Selector
from nrp_core.dsl.weights import MapWeights
from nrp_core.errors import NrpError, UnreadableError

_DIRECTIONS: Final = (Neuron2Robot, Robot2Neuron)
_DECORATORS: Final = (ParameterMapping, *_DIRECTIONS, NeuronMonitor)
_OF_NEURONS: Final = (MapSpikeSink, MapSpikeSource, MapReward, MapWeights, NeuronMonitor)
_NEURONS: Final = (Selector, BrainRoot, Selection, ProjectionSelector)
_PLAIN: Final = (int, float, str, Selector)
_OPERATORS: Final[dict[type[ast.operator], Callable[[Any, Any], Any]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


@dataclass(frozen=True, slots=True)
class Declared:
    """A transfer function as its file declares it.

    Args:
        function: the function with an empty body.
        source: its file.
        decorators: the decorator of each mapping, by its parameter.
    """

    function: TransferFunction
    source: PythonSource
    decorators: dict[str, ast.expr]


class _Unread(ParameterMapping):
    """A mapping that cannot be read."""

    def __call__(self, function: Any) -> TransferFunction:
        made: TransferFunction = (
            function if isinstance(function, TransferFunction) else Robot2Neuron()(function)
        )
        made.add(self)
        return made

    def _do_bind(self, binding: Binding) -> Adapter:
        return Adapter()

    def __str__(self) -> str:
        return "known only when it runs"


def declared_functions(listing: Listing) -> list[Declared]:
    """Return the functions of a listing that are decorated outside of other functions and loops."""
    reader = _Reader(listing)
    return [one for source in listing.sources for one in reader.read(source)]


class _Reader:
    """Reads the statements of a listing.

    Args:
        listing: the listing.
    """

    def __init__(self, listing: Listing) -> None:
        self._names, self._imports = dict(listing.names), listing.imports
        ours = [*vars(self._names["nrp"]).values(), self._names["Topic"]]
        self._ours = {id(one): one for one in ours if callable(one)}

    def read(self, source: PythonSource) -> Iterator[Declared]:
        """Yield the functions of one of its files."""
        for node in source.tree.body:
            match node:
                case ast.Assign([ast.Name(name)], value):
                    self._names.pop(name, None)
                    if (found := self._try(partial(self._value, value))) is not None:
                        self._names[name] = found
                case ast.Import() | ast.ImportFrom():
                    self._import(node)
                case ast.FunctionDef(decorator_list=[_, *_]):
                    declared = self._function(node, source)
                    if declared is not None:
                        yield declared

    @staticmethod
    def _try(call: Callable[[], Any]) -> Any:
        """Return the result of a call; None if it is unknown."""
        try:
            return call()
        except (NrpError, TypeError, ValueError, LookupError, AttributeError, ArithmeticError):
            return None

    def _import(self, node: ast.Import | ast.ImportFrom) -> None:
        """Record the names that a statement imports from our modules."""
        for alias in node.names:
            if isinstance(node, ast.Import):
                module = self._imports.substitute(alias.name)
                if alias.asname is not None and module is not None:
                    self._names[alias.asname] = module
            elif node.module and not node.level:
                module = self._imports.substitute(node.module)
                if hasattr(module, alias.name):
                    self._names[alias.asname or alias.name] = getattr(module, alias.name)

    def _function(self, node: ast.FunctionDef, source: PythonSource) -> Declared | None:
        if [argument.arg for argument in node.args.args][:1] != [TIME]:
            return None
        made: Any = _stub_of(node, source.path)
        decorators: dict[str, ast.expr] = {}
        for one in reversed(node.decorator_list):
            decorator: Any = self._try(partial(self._value, one)) or self._substitute(one)
            if isinstance(decorator, _DECORATORS):
                decorate: Any = decorator
                decorate.place = SourceLine(str(source.path), one.lineno)
                made = self._try(partial(decorate, made)) or made
            if isinstance(decorator, ParameterMapping):
                decorators[decorator.parameter] = one
        return Declared(made, source, decorators) if isinstance(made, TransferFunction) else None

    def _substitute(self, node: ast.expr) -> Any:
        """Return a substitute for a decorator that cannot be read."""
        match node:
            case ast.Call(func, [ast.Constant(str(parameter)), *_]):
                is_mapping = issubclass(self._try(partial(self._value, func)) or object, ParameterMapping)
                return _Unread(parameter) if is_mapping else None
            case ast.Call(func):
                kind = self._try(partial(self._value, func))
                return kind() if isinstance(kind, type) and issubclass(kind, _DIRECTIONS) else None
        return None

    def _value(self, node: ast.expr) -> Any:
        """Return the value of an expression of our objects and constants.

        Raises:
            UnreadableError: it is known only when it is executed.
        """
        match node:
            case ast.Constant(value):
                return value
            case ast.Name(name) if name in self._names:
                return self._names[name]
            case ast.Attribute(owner, name) if not name.startswith("_"):
                return getattr(self._value(owner), name)
            case ast.Subscript(owner, index) if isinstance(neurons := self._value(owner), _NEURONS):
                return neurons[self._value(index)]
            case ast.Slice(lower, upper, step):
                return slice(*(None if one is None else self._value(one) for one in (lower, upper, step)))
            case ast.Tuple(items) | ast.List(items):
                return (tuple if isinstance(node, ast.Tuple) else list)(map(self._value, items))
            case ast.UnaryOp(ast.USub(), operand):
                return -self._value(operand)
            case ast.BinOp(left, sign, right) if type(sign) in _OPERATORS:
                return _combined(_OPERATORS[type(sign)], self._value(left), self._value(right))
            case ast.Call():
                return self._call(node)
        raise UnreadableError("it is known only when it is executed")

    def _call(self, node: ast.Call) -> Any:
        """Call one of the names of the language, a kind of device, or a method of neurons."""
        called = self._value(node.func)
        is_method = isinstance(getattr(called, "__self__", None), _NEURONS)
        if not (id(called) in self._ours or is_method or called is slice or isinstance(called, DeviceKind)):
            raise UnreadableError("it is known only when it is executed")
        given = [self._argument(called, i, one) for i, one in enumerate(node.args)]
        named = {str(one.arg): self._argument(called, 1, one.value) for one in node.keywords}
        return called(*given, **named)

    def _argument(self, called: Any, place: int, node: ast.expr) -> Any:
        """Return the value of an argument; the text of neurons and names that cannot be read."""
        try:
            return self._value(node)
        except (NrpError, TypeError, ValueError, LookupError, AttributeError, ArithmeticError):
            if called is self._names["Topic"] and place == 0:
                return ast.unparse(node)
            if isinstance(called, type) and issubclass(called, _OF_NEURONS) and place <= 1:
                return Selector(_fail, ast.unparse(node))
            raise


def _fail(_root: object) -> NoReturn:
    raise UnreadableError("it is known only when it is executed")


def _combined(work: Callable[[Any, Any], Any], left: Any, right: Any) -> Any:
    """Return the result of an operator on plain values.

    Raises:
        UnreadableError: they are not plain, or a text is repeated.
    """
    are_plain = isinstance(left, _PLAIN) and isinstance(right, _PLAIN)
    if not are_plain or (work is operator.mul and str in (type(left), type(right))):
        raise UnreadableError("it is known only when it is executed")
    return work(left, right)


def _stub_of(node: ast.FunctionDef, path: Path) -> Any:
    """Return a function with the same parameters and an empty body; ``...`` replaces default values."""
    parts = node.args
    parameters = ast.arguments(
        posonlyargs=[ast.arg(one.arg) for one in parts.posonlyargs],
        args=[ast.arg(one.arg) for one in parts.args],
        vararg=ast.arg(parts.vararg.arg) if parts.vararg else None,
        kwonlyargs=[ast.arg(one.arg) for one in parts.kwonlyargs],
        kw_defaults=[None if one is None else ast.Constant(...) for one in parts.kw_defaults],
        kwarg=ast.arg(parts.kwarg.arg) if parts.kwarg else None,
        defaults=[ast.Constant(...) for _ in parts.defaults],
    )
    stub = ast.FunctionDef(node.name, parameters, [ast.Pass()], [])
    for part in ast.walk(stub):
        ast.copy_location(part, node)
    names: dict[str, Any] = {"__builtins__": {}}
    exec(compile(ast.Module([stub], []), str(path), "exec"), names)
    return names[node.name]
