"""A network of Brian2 as data for any backend with cells in equations. Importing this loads Brian2.

In a step Brian2 advances all cells, tests their thresholds, lets spikes arrive and resets cells. A cell in
equations receives spikes before it tests its threshold. So spikes are collected in a variable and change
the cell when it next advances: Brian2's order, one step later in the cycle. A spike of Brian2 at ``t`` is
at ``t + dt`` here, and delays are one step longer.

A cell advances by the assignments that Brian2's own integration method makes of its equations.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from textwrap import dedent
from typing import Any, Final

import brian2
import numpy as np
from brian2.core.functions import Function
from brian2.core.namespace import DEFAULT_UNITS
from brian2.core.variables import ArrayVariable, Constant, Subexpression
from brian2.groups.neurongroup import Resetter, StateUpdater, Thresholder
from brian2.groups.subgroup import Subgroup
from brian2.input.poissoninput import PoissonInput
from brian2.monitors.ratemonitor import PopulationRateMonitor
from brian2.monitors.spikemonitor import SpikeMonitor
from brian2.monitors.statemonitor import StateMonitor
from brian2.parsing.expressions import parse_expression_dimensions
from brian2.synapses.synapses import SynapticPathway
from brian2.units.fundamentalunits import DIMENSIONLESS
from nrp_core.brain import FloatArray, IntArray, Network, Population, Projection
from nrp_core.errors import CapabilityError
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.equations.model import CELL_TYPE, INPUT

from nrp_brain_brian2.options import RECEPTORS
from nrp_brain_brian2.script import Built

_PARTS: Final = (
    brian2.NeuronGroup, Subgroup, brian2.Synapses, StateUpdater, Thresholder, Resetter, SynapticPathway,
    PoissonInput, SpikeMonitor, StateMonitor, PopulationRateMonitor,
)  # fmt: skip
_UNITS: Final = {
    brian2.volt.dim: ("mV", 1e-3), brian2.amp.dim: ("nA", 1e-9), brian2.siemens.dim: ("uS", 1e-6),
    brian2.second.dim: ("ms", 1e-3), DIMENSIONLESS: ("1", 1.0),
}  # fmt: skip
_BASE: Final = ("metre", "kg", "second", "amp", "kelvin", "mol", "radian")
_FIRED, _FREE, _LAST = "fired", "not_refractory", "lastspike"
_FUNCTIONS: Final = {
    "abs": np.abs,
    "clip": np.clip,
    "int": np.trunc,
    "exp": np.exp,
    "log": np.log,
    "sqrt": np.sqrt,
}
Assignments = list[tuple[str, ast.expr]]


def unit_of(dim: Any) -> tuple[str, float]:
    """Return the unit of a dimension of Brian2, and its size in SI."""
    if dim in _UNITS:
        return _UNITS[dim]
    powers = [f"{name}**{int(power)}" for name, power in zip(_BASE, dim._dims, strict=True) if power]
    return "*".join(powers), 1.0


def network_of(built: Built) -> Network:
    """Return the network of a script.

    Raises:
        CapabilityError: it has anything but cells, sources, synapses that only transmit, and monitors.
        NetworkError: its equations use something that cells in equations do not support.
    """
    return _Conversion(built).network


def global_ids(built: Built, group: Any) -> IntArray:
    """Return the neurons of a group or subgroup in the network of a script."""
    source, start = (group.source, group.start) if isinstance(group, Subgroup) else (group, 0)
    first = 0
    for one in built.groups.values():
        if one.name == source.name:
            return first + start + np.arange(len(group))
        first += len(one)
    raise CapabilityError(f"Brian2: '{group.name}' is not in the network")


@dataclass
class _Arrival:
    """Spikes onto a variable: those of a pathway, or of independent sources."""

    target: Any
    variable: str
    source: Any
    pre: IntArray
    post: IntArray
    amounts: FloatArray
    delay_steps: IntArray
    rates: FloatArray = field(default_factory=lambda: np.empty(0))


class _Conversion:
    def __init__(self, built: Built) -> None:
        self._built = built
        self._namespace = dict(built.namespace)
        objects = list(built.network.sorted_objects)
        self._require_parts(objects)
        self._dt_s = self._step(built.groups.values())
        arrivals = [one for part in objects for one in self._arrivals(part)]
        self._labels = {group.name: label for label, group in built.groups.items()}
        self._populations = {}
        for label, group in built.groups.items():
            onto = dict.fromkeys(one.variable for one in arrivals if one.target.name == group.name)
            self._populations[label] = self._population(label, group, tuple(onto))
        self._projections: list[Projection] = []
        for one in arrivals:
            self._connect(one)
        self.network = Network(
            self._populations, tuple(self._projections), dict(built.views), timestep_ms=self._dt_s * 1e3
        )

    def _require_parts(self, objects: Iterable[Any]) -> None:
        for one in objects:
            is_known = type(one) in _PARTS or isinstance(
                one, brian2.PoissonGroup | brian2.SpikeGeneratorGroup
            )
            if not is_known:
                raise CapabilityError(
                    f"Brian2: '{one.name}', a {type(one).__name__}, has no equivalent here; a script with it "
                    "runs in Brian2: 'backend: brian2' and 'native: true' in the section 'brain'"
                )

    def _step(self, groups: Iterable[Any]) -> float:
        steps = {float(group.clock.dt) for group in groups}
        if len(steps) != 1:
            raise CapabilityError(f"Brian2: groups have steps of {sorted(steps)} s; here all have the same")
        return steps.pop()

    # -- cells

    def _population(self, label: str, group: Any, onto: tuple[str, ...]) -> Population:
        n = len(group)
        if isinstance(group, brian2.PoissonGroup):
            rates = group.variables["rates"]
            if isinstance(rates, Subexpression) and rates.identifiers & {"t", "t_in_timesteps"}:
                raise CapabilityError(f"Brian2: the rates of '{label}' change with the time, '{rates.expr}'")
            values = np.broadcast_to(np.asarray(group.state("rates", use_units=False)[:], float), n)
            return _poisson(label, values)
        if isinstance(group, brian2.SpikeGeneratorGroup):
            if 0.0 < float(group.variables["period"].get_value()) < np.inf:
                raise CapabilityError(f"Brian2: '{label}' repeats its spikes after a period")
            steps = np.floor(np.asarray(group._spike_time) / self._dt_s + 1e-3) + 1
            times_ms = steps * (self._dt_s * 1e3)
            cells = np.asarray(group._neuron_index)
            trains = tuple(np.sort(times_ms[cells == i]) for i in range(n))
            return Population(label, n, "SpikeSourceArray", {}, {}, trains)
        if set(group.events) - {"spike"}:
            raise CapabilityError(
                f"Brian2: '{label}' has the events {sorted(group.events)}; here only spikes"
            )
        return _Cells(label, group, self._namespace, self._dt_s, onto).population

    # -- synapses

    def _arrivals(self, part: Any) -> Iterator[_Arrival]:
        if isinstance(part, PoissonInput):
            yield self._poisson_input(part)
        if not isinstance(part, SynapticPathway):
            return
        synapses = part.synapses
        if part.event != "spike":
            raise CapabilityError(f"Brian2: '{part.name}' waits for '{part.event}'; here only for spikes")
        for name, value, sign in _increments(part):
            amounts = sign * _values(synapses, value, self._namespace, part.name)
            pre, post = (np.asarray(one[:], np.int64) for one in (synapses.i, synapses.j))
            source, pre = _whole(synapses.source, pre)
            target, post = _whole(synapses.target, post)
            delays_s = np.broadcast_to(np.asarray(part.variables["delay"].get_value(), float), len(pre))
            steps = (delays_s / self._dt_s + 0.5).astype(np.int64) + 1
            yield _Arrival(target, name, source, pre, post, np.broadcast_to(amounts, len(pre)), steps)

    def _poisson_input(self, part: Any) -> _Arrival:
        target, post = _whole(part._group, np.arange(len(part._group)))
        n, weight = len(post), part.weight
        if isinstance(weight, str):
            raise CapabilityError(f"Brian2: the weight of '{part.name}' is '{weight}'; here it is a number")
        rates = np.full(n, float(part.N) * float(part.rate))
        return _Arrival(
            target,
            part._target_var,
            None,
            np.arange(n),
            post,
            np.full(n, float(weight)),
            np.ones(n, np.int64),
            rates,
        )

    def _connect(self, one: _Arrival) -> None:
        post = self._labels[one.target.name]
        if one.source is None:
            pre = f"{post}_{one.variable}_input_{len(self._populations)}"
            self._populations[pre] = _poisson(pre, one.rates)
        else:
            pre = self._labels[one.source.name]
        equations = self._populations[post].equations
        assert equations is not None
        receptor = next(
            name
            for name, effect in equations.model.receptors.items()
            if effect.variable == _arriving(one.variable)
        )
        weights = np.asarray(one.amounts / unit_of(one.target.variables[one.variable].dim)[1], np.float64)
        label = f"{pre}→{post} {receptor} {len(self._projections)}"
        delays_ms = np.asarray(one.delay_steps * (self._dt_s * 1e3), np.float64)
        ends = one.pre.astype(np.int32), one.post.astype(np.int32)
        self._projections.append(Projection(label, pre, post, receptor, *ends, weights, delays_ms))


def _poisson(label: str, rates_hz: FloatArray) -> Population:
    n = len(rates_hz)
    values = {"rate": rates_hz, "start": np.zeros(n), "duration": np.full(n, 1e10)}
    return Population(label, n, "SpikeSourcePoisson", values)


def _whole(group: Any, indices: IntArray) -> tuple[Any, IntArray]:
    """Return the group of a subgroup, and indices in it."""
    return (group.source, indices + group.start) if isinstance(group, Subgroup) else (group, indices)


def _assignments(code: str) -> Assignments:
    """Return the assignments of Brian2's code, with increments written as assignments."""
    found: Assignments = []
    for line in ast.parse(dedent(code)).body:
        match line:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                found.append((name, value))
            case ast.AugAssign(target=ast.Name(id=name), op=op, value=value):
                found.append((name, ast.BinOp(ast.Name(name), op, value)))
            case _:
                raise CapabilityError(f"Brian2: '{ast.unparse(line)}' is not an assignment")
    return found


def _names(node: ast.AST) -> set[str]:
    called = {id(one.func) for one in ast.walk(node) if isinstance(one, ast.Call)}
    return {one.id for one in ast.walk(node) if isinstance(one, ast.Name) and id(one) not in called}


def _increments(part: Any) -> Iterator[tuple[str, ast.expr, float]]:
    """Yield the variables of the target that a pathway increases, with the increment and its sign."""
    synapses = part.synapses
    for name, value in _assignments(part.code):
        own = name.removesuffix("_post")
        is_target = part.prepost == "pre" and own in synapses.target.variables
        is_target &= name not in synapses.equations.names
        match value:
            case ast.BinOp(left=ast.Name(id=left), op=ast.Add() | ast.Sub() as op, right=right) if (
                is_target and left == name
            ):
                yield own, right, 1.0 if isinstance(op, ast.Add) else -1.0
            case _:
                raise CapabilityError(
                    f"Brian2: '{name} = {ast.unparse(value)}' of '{part.name}'; here a spike of the source "
                    "adds to a variable of the target"
                )


def _values(synapses: Any, value: ast.expr, namespace: Mapping[str, Any], owner: str) -> FloatArray:
    """Return the value of an expression for each synapse, in SI."""
    known: dict[str, Any] = dict(_FUNCTIONS)
    fixed = set(synapses.equations.parameter_names)
    for name in _names(value):
        variable = synapses.variables.get(name)
        if isinstance(variable, ArrayVariable | Subexpression):
            if (
                name not in fixed
                and not getattr(variable, "constant", False)
                and not _is_parameter(synapses, name)
            ):
                raise CapabilityError(
                    f"Brian2: '{ast.unparse(value)}' of '{owner}' depends on '{name}', which changes"
                )
            known[name] = np.asarray(synapses.state(name, use_units=False)[:])
        else:
            known[name] = _constant(synapses, name, namespace).value
    return np.asarray(
        eval(compile(ast.fix_missing_locations(ast.Expression(value)), owner, "eval"), known), float
    )


def _is_parameter(synapses: Any, name: str) -> bool:
    """Return whether a name is a parameter of the source or target."""
    for end, group in (("_pre", synapses.source), ("_post", synapses.target)):
        own = name.removesuffix(end)
        if own != name and own in getattr(getattr(group, "equations", None), "parameter_names", ()):
            return True
    return False


def _constant(group: Any, name: str, namespace: Mapping[str, Any]) -> Any:
    """Return a constant from outside a group."""
    found = group.resolve_all({name}, namespace, user_identifiers=set())[name]
    if not isinstance(found, Constant | Function):
        raise CapabilityError(f"Brian2: '{name}' of '{group.name}' belongs to another group")
    return found


def _arriving(variable: str) -> str:
    return f"{variable}_arriving"


class _Cells:
    """A group of neurons as cells in equations.

    Args:
        label: its name.
        group: the group.
        namespace: the variables that its equations use.
        dt_s: the step.
        onto: its variables to which spikes add.
    """

    def __init__(
        self, label: str, group: Any, namespace: Mapping[str, Any], dt_s: float, onto: tuple[str, ...]
    ) -> None:
        self._label, self._group, self._namespace, self._dt_s = label, group, namespace, dt_s
        if noise := group.equations.stochastic_variables:
            raise CapabilityError(
                f"Brian2: the equations of '{label}' have noise, {', '.join(sorted(noise))}, which cells in "
                "equations do not have"
            )
        group.state_updater.update_abstract_code(run_namespace=namespace)
        self._code = [
            (name, _Finite().visit(value)) for name, value in _assignments(group.state_updater.abstract_code)
        ]
        self._reset = _assignments(group.event_codes.get("spike") or "")
        self._rests = group._refractory is not False
        self._states = [*group.equations.diff_eq_names]
        self._states += [name for name, _ in self._reset if name in group.variables]
        self._states += onto
        self._onto = tuple(dict.fromkeys((*onto, *self._of_devices())))
        self._states = list(dict.fromkeys(self._states))
        self._lines: dict[str, str] = {}
        self._units: dict[str, str] = {}
        self._parameters: dict[str, FloatArray] = {}
        self._temporary: dict[str, Any] = {}
        own = group.equations.parameter_names
        currents = [
            one for one in own if group.variables[one].dim is brian2.amp.dim and one not in self._states
        ]
        self._current = currents[0] if len(currents) == 1 else None
        self.population = self._made()

    def _of_devices(self) -> Iterator[str]:
        """Yield the variables to which spikes of devices add."""
        for names in RECEPTORS.values():
            name = next((name for name in names if name in self._states), None)
            if name is not None and self._gate(name) is not None:
                yield name

    def _gate(self, name: str) -> str | None:
        """Return a factor for spikes onto a variable that arrive in the step of a spike; None if unknown.

        Brian2 resets the cell after they have arrived.
        """
        variable = self._group.variables[name]
        if self._rests and variable.conditional_write is not None:
            return f"*int({_FREE} > 0.5)"
        changes = [(one, value) for one, value in self._reset if one == name or name in _names(value)]
        if all(one == name and name not in _names(value) for one, value in changes):
            return f"*(1 - {_FIRED})" if changes else ""
        match changes:
            case [(_, ast.BinOp(left=ast.Name(id=left), op=ast.Add() | ast.Sub(), right=right))] if (
                left == name and changes[0][0] == name and name not in _names(right)
            ):
                return ""
        return None

    def _made(self) -> Population:
        steps, resets = list(self._arrived()), list(self._assigned(self._reset))
        steps += [f"{_FIRED} = 0", *self._assigned(self._code)]
        resets.append(f"{_FIRED} = 1")
        threshold = self._text(self._group.events.get("spike", "False"))
        if self._rests:
            resets += [f"{_LAST} = t - {self._dt_s!r}*second", f"{_FREE} = 0"]
            threshold = f"({threshold}) and {_FREE} > 0.5"
        receptors = self._receptors()
        rest = [name for name in self._states if name not in self._lines]
        for name in rest:
            self._declare(name, self._group.variables[name].dim)
        equations = CellEquations(
            equations="\n".join(self._lines.values()), threshold=threshold, reset="\n".join(resets),
            receptors=receptors, units=self._units, on_step="\n".join(steps),
            step_ms=self._dt_s * 1e3,
        )  # fmt: skip
        initial = {name: self._initial(name) for name in equations.model.variables}
        return Population(
            self._label, len(self._group), CELL_TYPE, self._parameters, initial, equations=equations
        )

    def _arrived(self) -> Iterator[str]:
        for name in self._onto:
            gate, arriving = self._gate(name), _arriving(name)
            if gate is None:
                raise CapabilityError(
                    f"Brian2: the reset of '{self._label}' uses '{name}', to which spikes add"
                )
            dim = self._group.variables[name].dim
            self._declare(arriving, dim)
            yield f"{name} = {name} + {arriving}{gate}"
            yield f"{arriving} = 0*{unit_of(dim)[0]}"
        self._declare(_FIRED, DIMENSIONLESS)
        if self._rests:
            self._declare(_FREE, DIMENSIONLESS)
            self._declare(_LAST, brian2.second.dim)

    def _receptors(self) -> dict[str, str]:
        found: dict[str, str] = {}
        for receptor, names in RECEPTORS.items():
            name = next((name for name in names if name in self._onto), None)
            if name is not None:
                found[receptor] = f"{_arriving(name)} += weight"
        for name in self._onto:
            effect = f"{_arriving(name)} += weight"
            if effect not in found.values():
                found[name] = effect
        return found

    def _declare(self, name: str, dim: Any) -> None:
        unit = unit_of(dim)[0]
        self._lines[name] = f"d{name}/dt = 0*{unit}/second : {unit}"

    def _initial(self, name: str) -> FloatArray:
        n, variable = len(self._group), self._group.variables.get(name)
        if name == _FREE:
            return np.ones(n)
        if variable is None or name not in (*self._states, _LAST):
            return np.zeros(n)
        values = np.asarray(variable.get_value(), float) / unit_of(variable.dim)[1]
        return np.broadcast_to(values, n).copy()

    # -- texts

    def _assigned(self, assignments: Assignments) -> Iterator[str]:
        for name, value in assignments:
            if name != _FREE and name not in self._group.variables and name not in self._temporary:
                known = {**self._group.variables, **self._temporary, **self._outside(value)}
                dim = parse_expression_dimensions(ast.unparse(value), known)
                self._temporary[name] = Constant(name, 1.0, dimensions=dim)
                self._declare(name, dim)
            text = self._expression(value)
            yield f"{name} = {f'int({text})' if name == _FREE else text}"

    def _outside(self, value: ast.expr) -> dict[str, Any]:
        names = {one.id for one in ast.walk(value) if isinstance(one, ast.Name)}
        names -= self._group.variables.keys() | self._temporary.keys()
        return dict(self._group.resolve_all(names, self._namespace, user_identifiers=set()))

    def _text(self, text: str) -> str:
        return self._expression(ast.parse(text.strip(), mode="eval").body)

    def _expression(self, value: ast.expr) -> str:
        return ast.unparse(ast.fix_missing_locations(_Rewritten(self._name, self._dt_s).visit(value)))

    def _name(self, name: str) -> str | None:
        """Return the replacement of a name, and declare it; None if the name is used as it is."""
        variable = self._group.variables.get(name)
        step = f"{self._dt_s!r}*second"
        built_in = {_FREE: f"({_FREE} > 0.5)", "t": f"(t - {step})", "dt": f"({step})"}
        if name in built_in:
            return built_in[name]
        if name in self._temporary or name in self._states or name == _LAST:
            return None
        if isinstance(variable, Subexpression):
            if name not in self._lines:
                text = self._text(variable.expr)
                self._lines[name] = f"{name} = {text} : {unit_of(variable.dim)[0]}"
            return None
        if isinstance(variable, ArrayVariable):
            if variable.owner.name != self._group.name:
                raise CapabilityError(f"Brian2: '{name}' of '{self._label}' is linked to another group")
            return self._parameter(name, variable.get_value(), variable.dim)
        return self._number(name, variable)

    def _number(self, name: str, variable: Any) -> str | None:
        """Return the replacement of a constant: a unit, a number of Brian2, or one of the script."""
        found = variable or _constant(self._group, name, self._namespace)
        if isinstance(found, Function) or name in ("pi", "e", "inf", "True", "False"):
            return None
        if name in DEFAULT_UNITS or variable is not None:
            return f"({float(found.value)!r}*{unit_of_si(found.dim)})"
        return self._parameter(name, found.value, found.dim)

    def _parameter(self, name: str, value: Any, dim: Any) -> str | None:
        own = INPUT if name == self._current else name
        unit, scale = unit_of(dim)
        self._units[own] = unit
        self._parameters[own] = np.broadcast_to(np.asarray(value, float) / scale, len(self._group)).copy()
        return own


def unit_of_si(dim: Any) -> str:
    """Return the unit of SI of a dimension."""
    return {"mV": "volt", "nA": "amp", "uS": "siemens", "ms": "second"}.get(unit_of(dim)[0], unit_of(dim)[0])


class _Finite(ast.NodeTransformer):
    """Replaces the factor that makes both numerator and denominator 0 in a refractory cell."""

    def __init__(self, *, below: bool = False) -> None:
        self._below = below

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        below = self._below or isinstance(node.op, ast.Div)
        return ast.BinOp(self.visit(node.left), node.op, _Finite(below=below).visit(node.right))

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if self._below and ast.unparse(node) == f"int({_FREE})":
            return ast.Constant(1.0)
        return node


class _Rewritten(ast.NodeTransformer):
    """Writes an expression of Brian2 in the notation of cells in equations."""

    def __init__(self, stands_for: Any, dt_s: float) -> None:
        self._stands_for, self._dt_s = stands_for, dt_s

    def visit_Name(self, node: ast.Name) -> ast.expr:
        text = self._stands_for(node.id)
        return node if text is None else ast.parse(text, mode="eval").body

    def visit_Call(self, node: ast.Call) -> ast.expr:
        assert isinstance(node.func, ast.Name)
        arguments = [self.visit(one) for one in node.args]
        if not arguments:
            return ast.Call(node.func, [], [])
        if node.func.id == "timestep":  # Brian2 rounds down, with a tolerance for rounding errors
            time = arguments[0]
            if isinstance(time, ast.Constant):  # in seconds
                time = ast.BinOp(time, ast.Mult(), ast.Name("second"))
            count = ast.BinOp(ast.BinOp(time, ast.Div(), arguments[1]), ast.Add(), ast.Constant(1e-3))
            return ast.Call(ast.Name("floor"), [count], [])
        return ast.Call(node.func, arguments, [])
