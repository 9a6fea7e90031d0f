"""The services of sessions; each waits for the thread of the session."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial, wraps
from inspect import signature
from textwrap import shorten
from typing import Any

from pydantic import ConfigDict, ValidationError, validate_call

from nrp_cockpit.session.adding import Adding
from nrp_cockpit.session.layout import SUFFIX, Layout
from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.session.looks import Looks
from nrp_cockpit.session.parameters import Parameters
from nrp_cockpit.session.recorded import RecordedSession
from nrp_cockpit.session.recorded_run import FIXED
from nrp_cockpit.session.session import Session
from nrp_cockpit.streaming.packing import between_in, portion
from nrp_cockpit.wire.calls import PREFIX
from nrp_cockpit.wire.hub import Service, Services
from nrp_core.clock import seconds
from nrp_core.errors import CapabilityError, ExperimentError, did_you_mean
from nrp_core.experiment import commands_of


def services_of(session: LiveSession) -> Services:
    """Return the services of a run; a second run follows the time of the first."""
    lead = getattr(session, "lead", session)
    commands = commands_of(session.run)
    functions, bodies, looks = session.functions, session.bodies, Looks(session.run)
    parameters, adding = Parameters(session), Adding(session.run)
    layout = layout_of(session)

    def steered(method: Callable[..., Any], name: str) -> Service:
        """Return a service that changes the run; its name on the timeline can contain arguments."""
        checked = validated(method)

        @wraps(method)
        def call(**fields: Any) -> Any:
            found = checked(**fields)
            session.steered(name.format_map(fields))
            return found

        return asked(session, call)

    def apply(
        files: Mapping[str, str], base: Mapping[str, str] | None = None, check: bool = True
    ) -> dict[str, Any]:
        return functions.apply(files, base=base, check=check)

    def recheck() -> dict[str, Any]:
        found = functions.recheck()
        session.ask(session.reports.all)
        return found

    def restore(id: str) -> None:  # noqa: A002  the name that the page gives it
        lead.restore(id)

    def forget(id: str) -> None:  # noqa: A002  likewise
        lead.forget(id)

    def messages(topic: str, after_ns: int = -1) -> dict[str, Any]:
        from_ns, sent = session.hub.past_of(topic)
        known = [(one.t_ns, one.payload) for one in sent]
        return portion(between_in(known), from_ns, after_ns, known[-1][0] if known else after_ns)

    steering: dict[str, Service] = {
        **going(lead),
        "snapshot": asked(lead, lead.snapshot),
        "restore": asked(lead, restore, "going back to the snapshot"),
        "forget": asked(lead, forget),
        "halt": validated(lead.halt),
        "record": asked(session, session.record),
        "publish": validated(commands["publish"]),
        "push": steered(bodies.push, "{body} pushed"),
        "place": steered(bodies.place, "{body} moved"),
        "bodies/add": steered(adding.add, "body added"),
        "bodies/remove": steered(adding.remove, "body removed"),
        "functions/apply": steered(apply, "functions changed"),
        "functions/recheck": validated(recheck),
        "functions/revert": steered(functions.revert, "functions reverted"),
        "functions/save": validated(functions.save),
        "functions/activate": steered(functions.activate, "{name} switched"),
        "parameters/cells": steered(parameters.set_cells, "{population} {name} = {value:g}"),
        "parameters/function": steered(parameters.set_constant, "{name} = {value:g}"),
        "weights/set": steered(parameters.set_weights, "weights of {projection} = {weight:g}"),
        "weights/scale": steered(
            parameters.scale_weights, "weights of {projection} \N{MULTIPLICATION SIGN} {factor:g}"
        ),
        **_layouts(layout),
    }
    watching: dict[str, Service] = {
        "functions/check": validated(functions.check),
        "functions/complete": asked(session, functions.complete),
        "bodies/models": asked(session, adding.models),
        "connections": asked(session, looks.connections),
        "parameters": asked(session, parameters.read),
        "membrane": asked(session, looks.membrane),
        "messages": validated(messages),
        "positions": asked(session, looks.positions),
        "weights": asked(session, looks.weights),
        "layout/load": validated(layout.load),
    }
    return prefixed(steering, watching)


def _layouts(layout: Layout) -> dict[str, Service]:
    names = ("save", "preset", "reset")
    return {f"layout/{name}": validated(getattr(layout, name)) for name in names}


def layout_of(session: LiveSession) -> Layout:
    """Return the layout beside the experiment of a run."""
    path = session.run.experiment.source.place.path
    return Layout(None if path is None else path.with_suffix(SUFFIX), session.hub.channels)


def layout_of_recording(session: RecordedSession) -> Layout:
    """Return the layout beside a recording."""
    folder = session.recording.folder.absolute()
    return Layout(folder.with_name(folder.name + SUFFIX), session.hub.channels)


_REFUSED = (
    "snapshot", "restore", "forget", "halt", "record", "branch", "compare", "part",
    "publish", "push", "place", "bodies/add", "bodies/remove",
    "functions/apply", "functions/recheck", "functions/revert", "functions/save", "functions/activate",
    "parameters/cells", "parameters/function", "weights/set", "weights/scale", "reseed",
)  # fmt: skip
"""The services that change a run and do not apply to a recording."""


def services_of_recording(session: RecordedSession) -> Services:
    """Return the services of a recording; those that would change it explain how to branch a run from it.

    A second recording follows the time of the first.
    """
    layout = layout_of_recording(session)

    def messages(topic: str, after_ns: int = -1) -> dict[str, Any]:
        if topic not in session.messages.topics:
            raise ExperimentError(
                f"there is no topic '{topic}'{did_you_mean(topic, session.messages.topics)}"
            )
        begin_ns, end_ns = session.messages.span_ns
        return portion(partial(session.messages.timed, topic), begin_ns, after_ns, end_ns)

    steering: dict[str, Service] = {
        **going(session.lead), **dict.fromkeys(_REFUSED, _refuse), **_layouts(layout)
    }  # fmt: skip
    watching: dict[str, Service] = {
        "functions/check": _refuse,
        "functions/complete": _refuse,
        "bodies/models": _refuse,
        "connections": _refuse,
        "parameters": _refuse,
        "membrane": _refuse,
        "messages": asked(session, messages),
        "positions": _refuse,
        "weights": _refuse,
        "layout/load": validated(layout.load),
    }
    return prefixed(steering, watching)


def _refuse(**_fields: Any) -> None:
    raise CapabilityError(FIXED)


def going(session: Session) -> dict[str, Service]:
    """Return the services that control time."""

    def seek(t_s: float) -> None:
        end_s = seconds(session.end_ns)
        if not 0.0 <= t_s <= end_s + seconds(session.timestep_ns):  # the end may lie between two steps
            raise ExperimentError(f"t_s: a time from 0 to {end_s:g} s, not {t_s:g} s")
        session.seek(t_s)

    def step(n: int = 1) -> None:
        most = -(-session.end_ns // session.timestep_ns)
        if n > most:
            raise ExperimentError(f"n: at most {most} steps, which are all of this run, not {n}")
        session.step(n)

    return {
        "play": asked(session, session.play),
        "pause": asked(session, session.pause),
        "step": asked(session, step),
        "step_back": asked(session, session.step_back, "stepping back"),
        "reset": asked(session, session.reset, "resetting"),
        "pace": asked(session, session.set_pace),
        "run_to": asked(session, session.run_to),
        "seek": asked(session, seek, "going there"),
    }


def asked(session: Session, method: Callable[..., Any], doing: str = "") -> Service:
    """Return a service that calls a method in the thread of a session."""
    checked = validated(method)

    @wraps(method)
    def call(**fields: Any) -> Any:
        return session.ask(lambda: checked(**fields), doing)

    return call


def validated(method: Callable[..., Any]) -> Service:
    """Return a method that refuses invalid arguments with one sentence."""
    checked = validate_call(config=ConfigDict(strict=True))(method)  # true is no number, and "2" neither

    @wraps(method)
    def call(**fields: Any) -> Any:
        try:
            return checked(**fields)
        except ValidationError as error:
            raise ExperimentError(_refusal(error, list(signature(method).parameters))) from None

    return call


def _refusal(error: ValidationError, names: list[str]) -> str:
    """Return a sentence about the first invalid argument of a method with these arguments."""
    first = error.errors(include_url=False)[0]
    name = ".".join(map(str, first["loc"]))
    if first["type"] == "unexpected_keyword_argument":
        return (
            f"there is no argument '{name}'{did_you_mean(name, names) if names else ', and none is needed'}"
        )
    if first["type"].startswith("missing"):
        return f"the argument '{name}' is missing"
    return f"{name}: {first['msg'][:1].lower()}{first['msg'][1:]}, not {shorten(repr(first['input']), 60)}"


def prefixed(steering: Mapping[str, Service], watching: Mapping[str, Service]) -> Services:
    """Return services under their full names."""
    return Services(
        {PREFIX + name: service for name, service in steering.items()},
        {PREFIX + name: service for name, service in watching.items()},
    )
