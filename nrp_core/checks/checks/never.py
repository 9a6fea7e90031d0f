"""Events that never happen, and loops that never end."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping

from nrp_core.checks.events import Add, Divide, Read
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.scopes import SCOPES
from nrp_core.checks.shapes import Instance, Known, Number, Shape
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.clock import from_seconds, seconds
from nrp_core.dsl.devices.devices import LeakyIntegratorDevice
from nrp_core.dsl.tf_lib.vision import RedShares
from nrp_core.experiment.model.event_schema import Event, causes_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.geometry_msgs import Quaternion

_TRIED = 5000
"""How many steps a period is compared with."""
_LOWERING = {"v_rest", "weight", "receptor_type", "i_offset", None}
"""Settings of integrators by which a voltage may be negative."""
PARTS = {RedShares: "a share from 0 to 1", Quaternion: "a part of a quaternion, from -1 to 1"}
"""Messages and results whose numbers are at most 1."""
_LEAVES = (ast.Return, ast.Raise, ast.Yield, ast.YieldFrom, ast.Await)


@checks_experiment(Code.NRP248)
def events_come_in_time(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events after the end of the run, and for events that wait for each other."""
    experiment = static.experiment
    for name, event in experiment.events.items():
        duration_s = f"{seconds(experiment.duration):g} s"
        if event.at is not None and event.at >= experiment.duration:
            message = f"'{name}' is at {seconds(event.at):g} s, and the run ends at {duration_s}"
            yield experiment.place("events", name, "at").finding(Code.NRP248, message, Level.WARNING)
        if event.when is not None and event.when.after > experiment.duration:
            message = (
                f"'{name}' is {seconds(event.when.after):g} s after another, and the run lasts {duration_s}"
            )
            yield experiment.place("events", name, "when", "after").finding(
                Code.NRP248, message, Level.WARNING
            )
        causes = causes_of(name, experiment.events)
        if name in causes:
            message = f"'{name}' waits for itself: {' -> '.join([name, *causes])}"
            place = experiment.place("events", name, "when", "event")
            yield place.finding(Code.NRP248, message, Level.WARNING)
        yield from _comes_too_late(name, experiment)


@checks_experiment(Code.NRP248)
def limits_of_criteria_end_in_time(static: StaticExperiment) -> Iterator[Finding]:
    """Look for criteria that allow more time than the run has."""
    experiment = static.experiment
    for name, criterion in experiment.criteria.items():
        if criterion.within_of is not None and criterion.within_of.time > experiment.duration:
            message = (
                f"'{name}' allows {seconds(criterion.within_of.time):g} s, and the run lasts "
                f"{seconds(experiment.duration):g} s"
            )
            yield experiment.place("criteria", name, "within_of", "time").finding(
                Code.NRP248, message, Level.WARNING
            )
        elif criterion.within_of is not None and criterion.within_of.event in experiment.events:
            first_ns = earliest_ns(criterion.within_of.event, experiment.events)
            if first_ns < experiment.duration < first_ns + criterion.within_of.time:
                message = (
                    f"'{name}' allows {seconds(criterion.within_of.time):g} s after "
                    f"'{criterion.within_of.event}', which is at {seconds(first_ns):g} s at the earliest, "
                    f"and the run ends at {seconds(experiment.duration):g} s"
                )
                yield experiment.place("criteria", name, "within_of", "time").finding(
                    Code.NRP248, message, Level.NOTE
                )


def _comes_too_late(name: str, experiment: Experiment) -> Iterator[Finding]:
    """Yield events that follow others so late that the run is over."""
    events, end_ns = experiment.events, experiment.duration
    first_ns, causes = earliest_ns(name, events), causes_of(name, events)
    alone_ns = max([_delay_ns(events[name]), *(earliest_ns(one, events) for one in causes)])
    if causes and alone_ns <= end_ns < first_ns:
        message = (
            f"'{name}' comes at {seconds(first_ns):g} s at the earliest, after "
            f"{' and '.join(map(repr, causes))}, and the run ends at {seconds(end_ns):g} s"
        )
        yield experiment.place("events", name, "when", "after").finding(Code.NRP248, message, Level.WARNING)


def earliest_ns(name: str, events: Mapping[str, Event]) -> int:
    """Return a time, ns, before which an event cannot happen."""
    return sum(_delay_ns(events[one]) for one in {name, *causes_of(name, events)} if one in events)


def _delay_ns(event: Event) -> int:
    """Return the earliest time of an event after the one that it waits for, or after the start."""
    if event.at is not None:
        return event.at
    return 0 if event.when is None else event.when.after


@checks_function(Code.NRP248)
def times_are_reached(function: CheckedFunction) -> Iterator[Finding]:
    """Look for comparisons of ``t`` with times that it never reaches."""
    duration_s = seconds(function.experiment.duration)
    for event in function.events:
        match event:
            case Add(
                ast.Compare(ast.Name("t"), _, [_]) as node, Number("s"), Known(int() | float() as bound)
            ):
                pass
            case Add(
                ast.Compare(_, _, [ast.Name("t")]) as node, Known(int() | float() as bound), Number("s")
            ):
                pass
            case _:
                continue
        if bound > duration_s:
            message = f"'t', in seconds, never reaches {bound:g}: the run ends at {duration_s:g} s"
            yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


@checks_function(Code.NRP248)
def times_are_met(function: CheckedFunction) -> Iterator[Finding]:
    """Look for tests whether ``t`` equals a time, or is a multiple of one, that miss it."""
    step_ns, starts_at = function.experiment.timestep, function.experiment.tf_time == "start"
    multiples = {}
    for event in function.events:
        match event:
            case Add(ast.Compare(_, [ast.Eq()], [_]) as node, Number("s"), Known(int() | float() as time)):
                if not isinstance(node.left, ast.Name):
                    continue
                if from_seconds(time) % step_ns or (time == 0 and not starts_at):
                    message = (
                        f"'t' never equals {time:g}: it is a multiple of {seconds(step_ns):g} s"
                        f"{'' if time else ', and the first step ends at that time'}"
                    )
                    yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)
            case Divide(
                ast.BinOp(ast.Name("t"), ast.Mod()) as node, Number("s"), Known(int() | float() as s)
            ):
                multiples[id(node)] = s
    for test in function.declared.own:
        match test:
            case ast.Compare(left, [ast.Eq()], [ast.Constant(0)]) if id(left) in multiples:
                message = _missed(multiples[id(left)], step_ns)
                if message:
                    yield function.declared.finding(Code.NRP248, test, message, Level.WARNING)


@checks_function(Code.NRP248)
def numbers_are_not_compared_with_texts(function: CheckedFunction) -> Iterator[Finding]:
    """Look for tests whether a number equals a text."""
    for event in function.events:
        match event:
            case Add(ast.Compare(_, [ast.Eq()], [_]) as node, Number(), Known(str())) | Add(
                ast.Compare(_, [ast.Eq()], [_]) as node, Known(str()), Number()
            ):
                message = f"'{excerpt(node)}' compares a number with a text: they are never equal"
                yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


@checks_function(Code.NRP248)
def parts_are_compared_with_parts(function: CheckedFunction) -> Iterator[Finding]:
    """Look for comparisons of a share of an image, or of a part of a quaternion, with a number beyond 1."""
    parts = {
        id(event.node): PARTS[event.owner.cls]
        for event in function.events
        if isinstance(event, Read) and isinstance(event.owner, Instance) and event.owner.cls in PARTS
    }
    for event in function.events:
        match event:
            case Add(ast.Compare(one, _, [other]) as node, left, right):
                for mine, bound in ((one, right), (other, left)):
                    match bound:
                        case Known(int() | float() as limit) if id(mine) in parts and abs(limit) > 1:
                            message = f"'{ast.unparse(mine)}' is {parts[id(mine)]}, never {limit:g}"
                            yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


@checks_function(Code.NRP320)
def voltages_are_compared_within_their_range(function: CheckedFunction) -> Iterator[Finding]:
    """Look for thresholds of a listening neuron that its voltage is always above."""
    resting = {
        id(event.node)
        for event in function.events
        if isinstance(event, Read) and event.name == "voltage" and isinstance(event.owner, Known)
        if isinstance(event.owner.value, LeakyIntegratorDevice) and _rests_at_0(function, event.owner)
    }
    for event in function.events:
        match event:
            case Add(
                ast.Compare(one, [ast.Gt() | ast.GtE()], [_]) as node, _, Known(int() | float() as limit)
            ):
                if id(one) in resting and limit < 0:
                    message = (
                        f"'{excerpt(node)}' is always true: an integrator rests at 0 mV, and spikes raise it"
                    )
                    yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)


def _rests_at_0(function: CheckedFunction, shape: Shape) -> bool:
    """Return whether the integrator of a parameter has no settings that let its voltage fall below 0."""
    decorator = function.declared.nodes.get(function.parameter_of(shape) or "")
    return isinstance(decorator, ast.Call) and not {one.arg for one in decorator.keywords} & _LOWERING


def _missed(period_s: float, step_ns: int) -> str:
    """Return how many multiples of a period a remainder of floats misses; empty if none."""
    period_ns = from_seconds(period_s)
    if period_ns <= 0:
        return ""
    steps = range(step_ns, (_TRIED + 1) * step_ns, step_ns)
    meant = [now_ns for now_ns in steps if now_ns % period_ns == 0]
    met = [now_ns for now_ns in meant if seconds(now_ns) % period_s == 0]
    if meant and len(met) == len(meant):
        return ""
    if not meant:
        return f"none of the first {_TRIED} steps of {seconds(step_ns):g} s is a multiple of {period_s:g} s"
    return (
        f"the remainder is 0 at {len(met)} of the first {len(meant)} multiples of {period_s:g} s, because "
        "numbers are rounded; throttling_rate runs a function at a rate"
    )


@checks_function(Code.NRP251)
def loops_end(function: CheckedFunction) -> Iterator[Finding]:
    """Look for ``while True`` loops without an exit."""
    for node in ast.walk(ast.Module(function.declared.node.body, [])):
        if isinstance(node, ast.While) and _is_true(node.test) and not _can_be_left(node):
            message = "this loop never ends; a transfer function runs once a step and returns"
            yield function.declared.finding(Code.NRP251, node, message, Level.WARNING)


def _is_true(test: ast.expr) -> bool:
    return isinstance(test, ast.Constant) and bool(test.value)


def _can_be_left(loop: ast.While) -> bool:
    """Return whether a statement in a loop leaves it; calls that may raise do not count."""
    waiting: list[tuple[ast.AST, bool]] = [(statement, True) for statement in loop.body]
    while waiting:
        node, is_own = waiting.pop()
        if isinstance(node, _LEAVES) or (is_own and isinstance(node, ast.Break)):
            return True
        if isinstance(node, (ast.For, ast.AsyncFor, ast.While)):
            waiting += [(child, False) for child in node.body]
            waiting += [(child, is_own) for child in node.orelse]
        elif not isinstance(node, SCOPES):
            waiting += [(child, is_own) for child in ast.iter_child_nodes(node)]
    return False
