"""Make all parts of an experiment except its engines; refuse experiments that cannot run.

Advice about an experiment that can run is not given here; see :mod:`nrp_core.checks`.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.time_limit import TimeLimit, TimeLimitExceeded
from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.backends import brains
from nrp_core.brain.devices.attached import source_among
from nrp_core.cle.wiring import declare_topics
from nrp_core.clock import StepPlan, dividing_step, from_milliseconds, milliseconds, seconds
from nrp_core.dsl.functions import TransferFunction, require_new_name
from nrp_core.dsl.testing import MockBrain, MockEngine, MockWorld
from nrp_core.errors import (
    CapabilityError,
    EndlessScriptError,
    NeuronSelectionError,
    TopicError,
    did_you_mean,
)
from nrp_core.experiment.backends import load_backend, named_errors
from nrp_core.experiment.making.interventions import check_capabilities, with_variants
from nrp_core.experiment.making.maker import maker_of, with_parameters, with_robot
from nrp_core.experiment.making.plan import B, Plan, PlanParts, ProgressCallback, Side, no_progress
from nrp_core.experiment.making.watch import Watch, declare_own, warn_of_missing_topics
from nrp_core.experiment.model.collector import Collector, Omission
from nrp_core.experiment.model.event_schema import END, START
from nrp_core.experiment.model.experiment import BackendSection, Build, Experiment, VoltageSection
from nrp_core.experiment.model.section import Key
from nrp_core.findings import Code, Finding, Findings, Level, has_errors
from nrp_core.findings.refusals import no_variable
from nrp_core.network.data import Network
from nrp_core.network.voltages import VOLTAGE
from nrp_core.quantities import RoundedNs, unit_of
from nrp_core.registry import Registry
from nrp_core.scene.clearance import with_clearance
from nrp_core.scene.devices import Noise
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Scene
from nrp_core.world.backend import WorldBackend
from nrp_core.world.backends import worlds
from nrp_core.world.domain_randomization import check_randomization
from nrp_core.world.engine_kit.jointed import PhysicsBackend
from nrp_core.world.engine_kit.planar_servo import planar_drives, servo_of
from nrp_core.world.sensors.sensor import with_imperfection
from nrp_core.world.topics import Direction, TopicInfo
from nrp_core.world.world import World

EXECUTING = "executing the brain script"
"""The beginning of the name of the task that executes a script of the experiment."""

Review = Callable[[Side[BrainBackend], Network], Findings]
"""Returns what a brain backend would change in a network; raises what it refuses."""


@checks_arguments()
def prepare(
    experiment: Experiment, progress: ProgressCallback = no_progress, build: Build | None = None
) -> Plan:
    """Make all parts of an experiment except its engines.

    Args:
        experiment: the experiment.
        progress: called with the name of each task as it begins.
        build: makes the network; see :func:`build_network`.

    Raises:
        BackendError: a backend is missing or broken.
        InvalidExperimentError: anything else is wrong; it carries all findings.
    """
    parts = make_parts(experiment, progress, build)
    functions = load_functions(parts)
    parts.collector.raise_errors()
    brain, world, network, scene, stage = parts.brain, parts.world, parts.network, parts.scene, parts.stage
    if brain is None or world is None or network is None or scene is None or stage is None:
        raise AssertionError("a part is missing without an error")
    warnings = tuple(parts.collector.findings)
    return Plan(experiment, brain, world, network, scene, stage, functions, parts.parameters, warnings)


def make_parts(
    experiment: Experiment,
    progress: ProgressCallback = no_progress,
    build: Build | None = None,
    review: Review | None = None,
) -> PlanParts:
    """Make the parts of an experiment except its transfer functions; mistakes become findings.

    Args:
        experiment: the experiment.
        progress: called with the name of each task as it begins.
        build: makes the network; see :func:`build_network`.
        review: reviews the network; by default the brain backend itself.
    """
    collector = Collector(experiment.source)
    brain = select_backend(collector, brains(), "brain", experiment.brain)
    world = select_backend(collector, worlds(), "world", experiment.world)
    _require_events(experiment, collector)
    given, (experiment, parameters) = experiment, with_parameters(experiment, collector)
    progress("reading the room and the robots")
    scene = _make_scene(experiment, world, collector)
    if world is not None and scene is not None:
        world = _fitted(given, world, scene, collector)
    if world is not None and isinstance(given.timestep, RoundedNs):
        world = _with_dividing_step(given, given.timestep, world, collector)
    _require_steps(given, brain, world, collector)
    if scene is not None:
        _require_units(experiment, scene, collector)
        if world is not None and isinstance(world.backend, PhysicsBackend):
            _require_drives(experiment, world, scene, collector)
    if build is None:
        progress(building(experiment))
    network = build_network(experiment, collector, build)
    if network is not None and network.timestep_ms is not None:
        _require_script_step(experiment, network.timestep_ms, collector)
    is_accepted = _is_accepted(experiment, brain, network, review or _review, collector)
    stage = None if scene is None else _make_stage(experiment, world, scene, collector)
    return PlanParts(experiment, brain, world, network, scene, stage, parameters, is_accepted, collector)


# -- backends


def select_backend(
    collector: Collector, registry: Registry[B], side: str, section: BackendSection
) -> Side[B] | None:
    """Return the backend selected by an experiment; mistakes go to the collector."""
    with collector.during(Code.NRP205, side, "backend"):
        backend, options = load_backend(registry, side, section.backend, section.options, collector.source)
        with named_errors(section.backend, "report its capabilities"):
            return Side(backend, options, backend.capabilities(options))
    return None


def _fitted(
    experiment: Experiment, world: Side[WorldBackend], scene: Scene, collector: Collector
) -> Side[WorldBackend]:
    """Return a world with the time step of its scene's file, if the backend uses it; report differences."""
    with named_errors(experiment.world.backend, "fit its options to the scene"):
        options, message = world.backend.fit(world.options, scene, experiment.timestep)
        if message:
            collector.add(Code.NRP372, message, "world", "scene", level=Level.NOTE)
        return Side(world.backend, options, world.backend.capabilities(options))


def _with_dividing_step(
    experiment: Experiment, period_ns: RoundedNs, world: Side[WorldBackend], collector: Collector
) -> Side[WorldBackend]:
    """Return a world whose step divides a rounded period, the longest up to its own; say what was rounded."""
    own_ns = step_ns = world.capabilities.step_ns
    if own_ns and period_ns % own_ns and "timestep" in type(world.options).model_fields:
        step_ns = dividing_step(own_ns, period_ns)
        options = world.options.model_copy(update={"timestep": step_ns})
        world = Side(world.backend, options, world.backend.capabilities(options))
    physics = f"; the physics step is {milliseconds(step_ns):g} ms, not {milliseconds(own_ns):g} ms"
    message = (
        f"timestep: '{period_ns.written}' is rounded to {milliseconds(period_ns):g} ms, and the duration to "
        f"{seconds(experiment.duration):g} s, {experiment.duration // period_ns} steps"
        f"{physics if step_ns != own_ns else ''}"
    )
    collector.add(Code.NRP372, message, "timestep", level=Level.NOTE)
    return world


def _require_steps(
    experiment: Experiment, brain: Side[BrainBackend] | None, world: Side[WorldBackend] | None,
    collector: Collector,
) -> None:  # fmt: skip
    """Require that the steps of both sides divide the step of the loop."""
    brain_step_ns = brain.capabilities.resolution_ns if brain else None
    world_step_ns = world.capabilities.step_ns if world else None
    with collector.during(Code.NRP372, *place_of_step(experiment)):
        StepPlan(experiment.timestep, brain_step_ns, world_step_ns)


def _require_script_step(experiment: Experiment, timestep_ms: float, collector: Collector) -> None:
    """Require that the loop stops at time steps of the brain script, as every simulator with a grid does."""
    step_ns, period_ns = from_milliseconds(timestep_ms), experiment.timestep
    if step_ns <= 0 or period_ns % step_ns:
        message = (
            f"the brain has a time step of {timestep_ms:g} ms (setup(timestep=...)), and the loop one of "
            f"{milliseconds(period_ns):g} ms, which is not a multiple of it"
        )
        collector.add(Code.NRP372, message, *place_of_step(experiment))


def place_of_step(experiment: Experiment) -> tuple[Key, ...]:
    """Return the keys of a time step given for one side, else those of the loop's time step."""
    for side in ("world", "brain"):
        keys = (side, "options", "timestep")
        if experiment.source.nearest(keys)[1] == keys:
            return keys
    return ("timestep",)


# -- the network


def building(experiment: Experiment) -> str:
    """Return the name of the task that makes the network, with the script that is executed."""
    name = ", ".join(path.name for path in experiment.brain.files.values())
    return f"{EXECUTING} {name}" if ".py" in name else f"reading the network {name}"


def build_network(experiment: Experiment, collector: Collector, build: Build | None = None) -> Network | None:
    """Return the network of an experiment; mistakes go to the collector.

    Args:
        experiment: the experiment.
        collector: receives the findings.
        build: makes the network; by default in this process, within the time limit of the experiment.
    """
    before = len(collector.findings)
    with collector.during(Code.NRP208, "brain", "model"):
        try:
            network = maker_of(experiment).network(experiment, build or partial(built_in_time, experiment))
            _require_recorded(experiment, network, collector)
            return with_variants(network, experiment, collector)
        except NeuronSelectionError as error:
            keys = ("brain", "populations", *(error.subject or "").split("."))
            collector.add(Code.NRP211, error.message, *keys, subject=error.subject)
    # a declaration of a parameter that is wrong ends the script, too
    known = {(one.path, one.line) for one in collector.findings[:before] if one.code is Code.NRP202}
    collector.findings[before:] = [
        one
        for one in collector.findings[before:]
        if one.code not in (Code.NRP208, Code.NRP202) or (one.path, one.line) not in known
    ]
    return None


def load_network_only(experiment: Experiment, build: Build | None = None) -> Network:
    """Return the network of an experiment alone.

    Args:
        experiment: the experiment.
        build: makes the network; see :func:`build_network`.

    Raises:
        InvalidExperimentError: it cannot be made.
    """
    collector = Collector(experiment.source)
    given, _ = with_parameters(experiment, collector)
    network = build_network(given, collector, build)
    collector.raise_errors()
    assert network is not None
    return network


def built_in_time(experiment: Experiment, make: Callable[[], Network]) -> Network:
    """Make a network in this process, within the time limit of the experiment.

    Raises:
        EndlessScriptError: it takes longer; with the line that the script has reached.
    """
    limit_ns, files = experiment.brain.time_limit, experiment.brain.files.values()
    limit = TimeLimit(None if limit_ns is None else seconds(limit_ns), name="brain.time_limit")
    try:
        with limit.watching():
            return limit.call(make)
    except TimeLimitExceeded as error:
        frames = reversed(traceback.extract_tb(error.__traceback__))
        here = ((Path(frame.filename), frame.lineno) for frame in frames)
        file, line = next((place for place in here if place[0] in files), (next(iter(files)), None))
        reached = "it had not reached its first line" if line is None else "it was still executing this line"
        message = f"the brain script {error}; {reached}"
        raise EndlessScriptError(message, path=file, line=line) from None


def _is_accepted(
    experiment: Experiment, brain: Side[BrainBackend] | None, network: Network | None, review: Review,
    collector: Collector,
) -> bool:  # fmt: skip
    """Return whether the brain backend accepts the network; report the changes that it would make."""
    if brain is None or network is None:
        return False
    name, before = experiment.brain.backend, len(collector.findings)
    check_capabilities(experiment, brain.capabilities, collector)
    with collector.during(Code.NRP216, "brain", "backend"):
        brain.capabilities.require(network, name)
        shown = brain.capabilities.extended(network).state_variables
        if experiment.recording.voltages and VOLTAGE not in shown:
            raise CapabilityError(f"'{name}' does not show membrane voltages: leave out 'recording.voltages'")
        with collector.during(Code.NRP216, "brain", "model"), named_errors(name, "accept the network"):
            collector.place(review(brain, network), "brain", "model")
    return not has_errors(collector.findings[before:])


def _review(brain: Side[BrainBackend], network: Network) -> Findings:
    return Findings(brain.backend.warnings(network, brain.options), general=Code.NRP217)


# -- the scene


def _make_scene(
    experiment: Experiment, world: Side[WorldBackend] | None, collector: Collector
) -> Scene | None:
    scene, robots, maker = None, experiment.world.robots, maker_of(experiment)
    if experiment.world.scene is None and not (world is not None and world.capabilities.own_scene):
        collector.add(Code.NRP201, "'world' needs the key 'scene'", "world")
        return None
    with collector.during(Code.NRP209, "world", "scene"):
        scene = maker.room(experiment)
    whole, added = scene or Scene(()), 0
    for name, section in robots.items():
        omission = None if experiment.strict else Omission(Code.NRP256, "robot", name)
        with collector.during(Code.NRP209, "world", "robots", name, omission=omission):
            if scene is not None or section.model is not None:
                whole, added = with_robot(whole, experiment, name, maker), added + 1
    if scene is None or (experiment.strict and added < len(robots)):
        return None
    with collector.during(Code.NRP209, "world", "robots"):
        scene = with_clearance(whole)
        collector.findings += scene.warnings
        return _with_ranges(experiment, _with_imperfections(experiment, scene, collector), collector)
    return None


def _with_imperfections(experiment: Experiment, scene: Scene, collector: Collector) -> Scene:
    """Return the scene with the imperfections of sensors and commands in the experiment."""
    for topic, section in experiment.world.sensors.items():
        with collector.during(Code.NRP202, "world", "sensors", topic):
            noise = None if section.noise is None else Noise(section.bias, section.noise)
            delay = None if section.delay is None else seconds(section.delay)
            scene = with_imperfection(scene, topic, noise=noise, delay=delay, drop_out=section.drop_out)
    delays = tuple((topic, seconds(section.delay)) for topic, section in experiment.world.commands.items())
    return replace(scene, command_delays=delays) if delays else scene  # a new scene is checked again


def _with_ranges(experiment: Experiment, scene: Scene, collector: Collector) -> Scene:
    """Return the scene with the ranges from which each seed draws."""
    for quantity, pattern, section in experiment.world.randomize.entries():
        with collector.during(Code.NRP202, "world", "randomize", quantity, pattern):
            drawn = section.of(quantity, pattern)
            check_randomization(drawn, scene)
            scene = replace(scene, randomize=(*scene.randomize, drawn))
    return scene


def _require_units(experiment: Experiment, scene: Scene, collector: Collector) -> None:
    """Require angles for joints that turn, and lengths for joints that slide."""
    robots = {model.name: model for model in scene.models if model.name in experiment.world.robots}
    for name, model in robots.items():
        kinds = {joint.name: joint.kind for joint in model.joints}
        for joint in sorted(kinds.keys() & experiment.world.robots[name].joints.keys()):
            keys = "world", "robots", name, "joints", joint
            wanted = "length" if kinds[joint] == "prismatic" else "angle"
            written = experiment.source.nearest(keys)[0].value
            if unit_of(written) not in ("", wanted):
                message = f"the joint '{joint}' of '{name}' takes {wanted}s, not '{written}'"
                collector.add(Code.NRP209, message, *keys)


def _require_drives(
    experiment: Experiment, world: Side[WorldBackend], scene: Scene, collector: Collector
) -> None:
    """Make the servo of each drive, as an engine does when it opens the scene."""
    if not world.capabilities.dynamics or world.capabilities.own_scene:
        return
    for model in scene.models:
        is_robot = model.name in experiment.world.robots
        keys = ("world", "robots", model.name) if is_robot else ("world", "scene")
        with collector.during(Code.NRP209, *keys):
            for drive in planar_drives(model):
                servo_of(model, drive, bodies_of(model), scene.gravity)


# -- topics, events, criteria and functions, set up as for a run with mocks


def _make_stage(
    experiment: Experiment, world: Side[WorldBackend] | None, scene: Scene, collector: Collector
) -> World | None:
    """Return a world without an engine, with the topics of the experiment; None after mistakes."""
    topics, stage = _own_topics(experiment, world, collector), None
    if topics is None:
        return None
    with collector.during(Code.NRP209, "world", "robots"):
        known = MockWorld(scene=scene).topics if topics else {}
        others = [topic for topic in topics if topic.name not in known]
        stage = MockWorld(engine=MockEngine(scene, topics=others))
    if stage is None or not declare_own(experiment, stage, collector):
        return None
    for topic in experiment.world.sensors:
        with collector.during(Code.NRP202, "world", "sensors", topic):
            _require_published(stage, topic)
    Watch(experiment, stage, collector)
    return stage


def _require_published(world: World, topic: str) -> None:
    """Refuse imperfections of a topic that the world does not publish itself.

    Raises:
        TopicError: the topic does not exist, or only functions publish on it.
    """
    parts = [part for part in world.parts.all if topic not in part.pushed_topics]
    served = [each.name for part in parts for each in part.topics if each.direction & Direction.OUT]
    if topic not in served:
        raise TopicError(f"the world does not publish '{topic}'{did_you_mean(topic, served)}")


def _own_topics(
    experiment: Experiment, world: Side[WorldBackend] | None, collector: Collector
) -> Sequence[TopicInfo] | None:
    """Return the topics that belong to the world, not to its scene; None if an option is wrong."""
    if world is None:
        return ()
    with (
        collector.during(Code.NRP202, "world", "options"),
        named_errors(experiment.world.backend, "report its topics"),
    ):
        return world.backend.topics(world.options)
    return None


def load_functions(parts: PlanParts) -> tuple[TransferFunction, ...]:
    """Return the transfer functions of an experiment, without those that cannot be bound; add findings."""
    experiment, collector = parts.experiment, parts.collector
    functions = tuple(maker_of(experiment).functions(experiment, collector))
    if parts.network is None or parts.stage is None:
        return functions
    before = len(collector.findings)
    with collector.during(Code.NRP216, "brain", "backend"):
        functions = _bind_to_mocks(functions, mock_brain(parts), parts.stage, experiment, collector)
    collector.findings[before:] = name_cause(collector.findings[before:], experiment, parts.network)
    return functions


def mock_brain(parts: PlanParts) -> MockBrain:
    """Return a brain without a simulator that refuses the same calls as the backend.

    Raises:
        CapabilityError: it refuses the network.
    """
    assert parts.network is not None
    capabilities = parts.brain.capabilities if parts.brain and parts.is_accepted else None
    return MockBrain(parts.network, capabilities=capabilities)


def _bind_to_mocks(
    functions: Sequence[TransferFunction], brain: MockBrain, stage: World, experiment: Experiment,
    collector: Collector,
) -> tuple[TransferFunction, ...]:  # fmt: skip
    """Return the functions that can be bound, after binding them to mocks once."""
    warn_of_missing_topics(collector, experiment, stage, functions)
    declare_topics(functions, stage)
    variables: dict[str, Any] = {}
    bound: list[TransferFunction] = []
    for function in functions:
        omission = None if experiment.strict else Omission(Code.NRP272, "transfer function", function.name)
        with collector.during(Code.NRP210, "transfer_functions", omission=omission):
            require_new_name(function, bound)
            bound.append(function.bind(brain, stage, variables=variables))
    for function in bound:
        function.unbind()
    return tuple(bound)


def name_cause(found: Sequence[Finding], experiment: Experiment, network: Network) -> list[Finding]:
    """Return findings; merge errors of devices on a brain without cells into one about its file."""
    others = [one for one in found if (one.code, one.level) != (Code.NRP211, Level.ERROR)]
    if network.populations or len(others) == len(found):
        return list(found)
    files = experiment.brain.files.values()
    is_other = any(path in experiment.transfer_functions for path in files)
    cause = "it is a file of transfer functions" if is_other else "is it the file of the brain?"
    name = ", ".join(path.name for path in files)
    message = f"{name} makes no cells, and devices of transfer functions use some: {cause}"
    return [*others, experiment.place("brain", "model").finding(Code.NRP211, message)]


def _require_recorded(experiment: Experiment, network: Network, collector: Collector) -> None:
    """Require that the populations that a recording leaves out and the cells that it samples exist."""
    for i, label in enumerate(experiment.recording.exclude):
        if label not in network.populations:
            message = f"no population '{label}'{did_you_mean(label, network.populations)}"
            collector.add(Code.NRP211, message, "recording", "exclude", i)
    for label, section in experiment.recording.voltages.items():
        with collector.during(Code.NRP211, "recording", "voltages", label):
            _require_cells(label, section, network)


def _require_cells(label: str, section: VoltageSection, network: Network) -> None:
    """Require that cells exist and have a voltage."""
    ids = network.neurons(label)
    if (absent := max(section.cells or (0,))) >= len(ids):
        raise NeuronSelectionError(f"'{label}' has no cell {absent}; valid: 0 to {len(ids) - 1}")
    if (source := source_among(network, ids)) is not None:
        raise no_variable(source, VOLTAGE, source=True)


# -- events


def _require_events(experiment: Experiment, collector: Collector) -> None:
    for keys, name in event_references(experiment):
        if name not in experiment.events:
            message = f"there is no event '{name}'{did_you_mean(name, experiment.events)}"
            collector.add(Code.NRP213, message, *keys)


def event_references(experiment: Experiment) -> Iterator[tuple[tuple[Key, ...], str]]:
    """Yield every place where an experiment names an event, with the name."""
    for name, event in experiment.events.items():
        if event.when is not None and event.when.event is not None:
            yield ("events", name, "when", "event"), event.when.event
    for name, criterion in experiment.criteria.items():
        if criterion.within_of is not None:
            yield ("criteria", name, "within_of", "event"), criterion.within_of.event
        if isinstance(criterion.by, str) and criterion.by not in (START, END):
            yield ("criteria", name, "by"), criterion.by
        for keys, during in criterion.periods():
            for key in ("since", "until"):
                point = getattr(during, key)
                if isinstance(point, str) and point not in (START, END):
                    yield ("criteria", name, *keys, "during", key), point


def open_engine(section: BackendSection, side: Side[Any], content: Network | Scene, seed: int) -> Any:
    """Open the brain or the world of a section of an experiment."""
    with named_errors(section.backend, "open"):
        return side.backend.open(content, seed=seed, options=side.options)


def open_world_like(first: World, section: BackendSection, side: Side[Any], seed: int) -> World:
    """Open the scene of a world once more; the two worlds share constant data."""
    with named_errors(section.backend, "open"):
        world: World = side.backend.open_another(first, seed=seed, options=side.options)
        return world
