"""Make all parts of an experiment except its engines, and find all mistakes in it."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial, reduce
from typing import Any, Generic, TypeVar

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.backends import brains
from nrp_core.brain.network.data import Network
from nrp_core.brain.network.implausible import implausible
from nrp_core.cle.time_limit import TimeLimit, TimeLimitExceeded
from nrp_core.cle.wiring import declare_topics
from nrp_core.clock import NS_PER_MS, StepPlan, milliseconds, seconds
from nrp_core.dsl.functions.collector import require_new_name
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.testing.mocks import MockBrain, MockEngine, MockWorld
from nrp_core.errors import EndlessScriptError, NeuronSelectionError, SceneError, did_you_mean
from nrp_core.experiment.backends import load_backend, named
from nrp_core.experiment.making.doubtful_mappings import doubtful_mappings
from nrp_core.experiment.making.interventions import check_capabilities, with_variants
from nrp_core.experiment.making.maker import maker_of
from nrp_core.experiment.making.parameters import Parameters, with_parameters
from nrp_core.experiment.making.start_poses import falling, things_fall, wrong_starts, wrong_units
from nrp_core.experiment.making.watch import Watch, declare_own, warn_of_missing_topics
from nrp_core.experiment.model.collector import Collector, Omission
from nrp_core.experiment.model.event_schema import END, START
from nrp_core.experiment.model.experiment import BackendSection, Build, Experiment
from nrp_core.experiment.model.tree import Key
from nrp_core.findings import Code, Finding, Findings, Level, has_errors
from nrp_core.registry import Registry
from nrp_core.world.backends import worlds
from nrp_core.world.drives.implausible import implausible_drives, weightless_wheels
from nrp_core.world.engine_kit.jointed import PhysicsBackend
from nrp_core.world.engine_kit.planar_servo import planar_drives, servo_of
from nrp_core.world.interface import WorldBackend
from nrp_core.world.raycast.solids import below_ground, buried
from nrp_core.world.scene import implausible as scene_plausibility
from nrp_core.world.scene.devices import Noise
from nrp_core.world.scene.merged_bodies import bodies_of
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.sensors.sensor import with_imperfection
from nrp_core.world.topics import TopicInfo
from nrp_core.world.world import World

ProgressCallback = Callable[[str], None]
"""Called with the name of each task as it begins."""

_MOST_STEPS = 1000
"""Steps of a physics engine in one of the loop; the smallest robots need a hundred."""

_LONGEST_NS = 10 * NS_PER_MS
"""The longest step of Gymnasium's models that touch something; Gazebo takes 1 ms and MuJoCo 2 ms."""

EXECUTING = "executing the brain script"
"""The beginning of the name of the task that executes a script of the experiment."""

B = TypeVar("B", BrainBackend, WorldBackend)


def no_progress(task: str) -> None:
    """Report no progress."""


@dataclass(frozen=True, slots=True)
class Side(Generic[B]):
    """A backend as selected by an experiment.

    Args:
        backend: the backend.
        options: an instance of its class of options.
        capabilities: its capabilities with these options.
    """

    backend: B
    options: Any
    capabilities: Any


@dataclass(frozen=True, slots=True)
class Plan:
    """A consistent experiment: everything it needs to open its engines.

    Args:
        experiment: the experiment.
        brain, world: the two backends.
        network: the network of the brain.
        scene: the scene of the world, robots included.
        functions: the transfer functions, not yet bound.
        parameters: those of the brain script and the transfer functions, with their values.
        warnings: findings that do not prevent a run.
    """

    experiment: Experiment
    brain: Side[BrainBackend]
    world: Side[WorldBackend]
    network: Network
    scene: Scene
    functions: tuple[TransferFunction, ...]
    parameters: Parameters
    warnings: tuple[Finding, ...]


@checks_arguments()
def prepare(
    experiment: Experiment, progress: ProgressCallback = no_progress, build: Build | None = None
) -> Plan:
    """Make all parts of an experiment except its engines.

    Args:
        experiment: the experiment.
        progress: called with the name of each task as it begins.
        build: makes the network; see :func:`network_of`.

    Raises:
        BackendError: a backend is missing or broken.
        InvalidExperimentError: anything else is wrong; it carries all findings.
    """
    examined = Examination(experiment, progress, build)
    examined.collector.raise_errors()
    assert examined.brain is not None
    assert examined.world is not None
    assert examined.network is not None
    assert examined.scene is not None
    return Plan(
        experiment,
        examined.brain,
        examined.world,
        examined.network,
        examined.scene,
        examined.functions,
        examined.parameters,
        tuple(examined.collector.findings),
    )


def side_of(
    collector: Collector, registry: Registry[B], side: str, section: BackendSection
) -> Side[B] | None:
    """Return the backend selected by an experiment; mistakes go to the collector."""
    with collector.during(Code.NRP205, side, "backend"):
        backend, options = load_backend(registry, side, section.backend, section.options, collector.source)
        with named(section.backend, "report its capabilities"):
            return Side(backend, options, backend.capabilities(options))
    return None


def building(experiment: Experiment) -> str:
    """Return the name of the task that makes the network, with the script that is executed."""
    name = experiment.brain.model.name
    return f"{EXECUTING} {name}" if name.endswith(".py") else f"reading the network {name}"


def network_of(experiment: Experiment, collector: Collector, build: Build | None = None) -> Network | None:
    """Return the network of an experiment; mistakes go to the collector.

    Args:
        experiment: the experiment.
        collector: receives the findings.
        build: makes the network; by default in this process, within the time limit of the experiment.
    """
    before = len(collector.findings)
    is_script = experiment.brain.model.suffix == ".py"
    with collector.during(Code.NRP208 if is_script else Code.NRP343, "brain", "model"):
        try:
            network = maker_of(experiment).network(experiment, build or partial(built_in_time, experiment))
            return with_variants(network, experiment, collector)
        except NeuronSelectionError as error:
            keys = ("brain", "populations", error.subject or "")
            collector.add(Code.NRP211, error.message, *keys, subject=error.subject)
    # a declaration of a parameter that is wrong ends the script, too
    known = {
        (one.path, one.line) for one in collector.findings[:before] if one.code in (Code.NRP289, Code.NRP351)
    }
    collector.findings[before:] = [
        one
        for one in collector.findings[before:]
        if one.code not in (Code.NRP208, Code.NRP351) or (one.path, one.line) not in known
    ]
    return None


def network_for(experiment: Experiment, build: Build | None = None) -> Network:
    """Return the network of an experiment alone.

    Args:
        experiment: the experiment.
        build: makes the network; see :func:`network_of`.

    Raises:
        InvalidExperimentError: it cannot be made.
    """
    collector = Collector(experiment.source)
    given, _ = with_parameters(experiment, collector)
    network = network_of(given, collector, build)
    collector.raise_errors()
    assert network is not None
    return network


def built_in_time(experiment: Experiment, make: Callable[[], Network]) -> Network:
    """Make a network in this process, within the time limit of the experiment.

    Raises:
        EndlessScriptError: it takes longer; with the line that the script has reached.
    """
    limit_ns, file = experiment.brain.time_limit, experiment.brain.model
    limit = TimeLimit(None if limit_ns is None else seconds(limit_ns), name="brain.time_limit")
    try:
        with limit.watching():
            return limit.call(make)
    except TimeLimitExceeded as error:
        frames = reversed(traceback.extract_tb(error.__traceback__))
        line = next((frame.lineno for frame in frames if frame.filename == str(file)), None)
        reached = "it had not reached its first line" if line is None else "it was still executing this line"
        message = f"the brain script {error}; {reached}"
        raise EndlessScriptError(message, path=file, line=line) from None


class Examination:
    """A check of an experiment; each part is None if it could not be made.

    Args:
        experiment: the experiment.
        progress: called with the name of each task as it begins.
        build: makes the network; see :func:`network_of`.
    """

    def __init__(
        self, experiment: Experiment, progress: ProgressCallback, build: Build | None = None
    ) -> None:
        self._experiment = experiment
        self._lapse = Level.ERROR if experiment.strict else Level.WARNING
        self.collector = Collector(experiment.source)
        self.brain = side_of(self.collector, brains(), "brain", experiment.brain)
        self.world = side_of(self.collector, worlds(), "world", experiment.world)
        self._check_steps()
        self._check_event_names()
        self._experiment, self.parameters = with_parameters(experiment, self.collector)
        progress("reading the room and the robots")
        self.scene = self._scene()
        self._check_starts()
        self._check_light()
        if build is None:
            progress(building(experiment))
        self.network = network_of(self._experiment, self.collector, build)
        self._fits = self._brain_fits()
        self.functions = tuple(maker_of(experiment).functions(self._experiment, self.collector))
        self._check_together()

    # -- the parts

    def _scene(self) -> Scene | None:
        scene, robots = None, self._experiment.world.robots
        if self._lacks_scene():
            self.collector.add(Code.NRP203, "'world' needs the key 'scene'", "world")
            return None
        with self.collector.during(Code.NRP209, "world", "scene"):
            scene = maker_of(self._experiment).room(self._experiment)
        models: list[Model] = []
        for name in robots:
            omission = None if self._experiment.strict else Omission(Code.NRP256, "robot", name)
            with self.collector.during(Code.NRP209, "world", "robots", name, omission=omission):
                if scene is not None and any(model.name == name for model in scene.models):
                    swapped = "; is 'scene' the file of a robot?" * (len(scene.models) == 1)
                    message = f"the room already has a model '{name}': rename the robot, or the model"
                    raise SceneError(message + swapped)
                models.append(maker_of(self._experiment).robot(self._experiment, name))
        if scene is None or (self._experiment.strict and len(models) < len(robots)):
            return None
        with self.collector.during(Code.NRP209, "world", "robots"):
            scene = reduce(Scene.with_model, models, scene)
            self.collector.findings += scene.warnings
            return self._with_sensors(scene)
        return None

    def _lacks_scene(self) -> bool:
        has_own = self.world is not None and self.world.capabilities.own_scene
        return self._experiment.world.scene is None and not has_own

    def _with_sensors(self, scene: Scene) -> Scene:
        """Return the scene with the imperfections of sensors in the experiment."""
        for topic, section in self._experiment.world.sensors.items():
            with self.collector.during(Code.NRP202, "world", "sensors", topic):
                noise = None if section.noise is None else Noise(section.bias, section.noise)
                delay = None if section.delay is None else seconds(section.delay)
                scene = with_imperfection(scene, topic, noise=noise, delay=delay, drop_out=section.drop_out)
        return scene

    # -- consistency of the parts

    def _check_steps(self) -> None:
        brain_step_ns = self.brain.capabilities.resolution_ns if self.brain else None
        world_step_ns = self.world.capabilities.step_ns if self.world else None
        written, doubt = self._step_written(), ""
        with self.collector.during(Code.NRP207, *written):
            StepPlan(self._experiment.timestep, brain_step_ns, world_step_ns)
        falls = self.world is not None and things_fall(self.world.capabilities)
        if world_step_ns and self._experiment.timestep > _MOST_STEPS * world_step_ns:
            doubt = (
                f"the world takes {self._experiment.timestep // world_step_ns} steps of "
                f"{milliseconds(world_step_ns):g} ms in each step of the loop; is the unit of its step wrong?"
            )
        elif world_step_ns and falls and written[0] == "world" and world_step_ns > _LONGEST_NS:
            doubt = (
                f"the physics step is {milliseconds(world_step_ns):g} ms, and 1 to 5 ms are usual: contacts "
                "and controllers act late, so that robots move otherwise; is the step of the loop meant?"
            )
        if doubt:
            self.collector.add(Code.NRP298, doubt, *written, level=Level.WARNING)

    def _step_written(self) -> tuple[Key, ...]:
        """Return the keys of a time step given for one side, else those of the loop's time step."""
        for side in ("world", "brain"):
            keys = (side, "options", "timestep")
            if self._experiment.source.nearest(keys)[1] == keys:
                return keys
        return ("timestep",)

    def _check_starts(self) -> None:
        if self.scene is not None:
            for keys, message in wrong_units(self._experiment, self.scene):
                self.collector.add(Code.NRP209, message, *keys)
        if self.scene is None or self.world is None or not things_fall(self.world.capabilities):
            return
        if isinstance(self.world.backend, PhysicsBackend):
            self._check_drives(self.scene)
        for robot, sentence in scene_plausibility.implausible(self.scene, self._experiment.world.robots):
            keys = ("world", "scene") if robot is None else ("world", "robots", robot)
            self.collector.add(Code.NRP298, sentence, *keys, level=Level.WARNING)
        for robot, sentence in self._wrong_drives(self.scene):
            self.collector.add(Code.NRP298, sentence, "world", "robots", robot, level=Level.WARNING)
        self._check_depths(self.scene)
        for message in falling(self.scene, self._experiment.world.robots):
            self.collector.add(Code.NRP292, message, "world", "scene", level=Level.WARNING)
        for name, code, message in wrong_starts(self.scene, self._experiment.world.robots):
            self.collector.add(code, message, "world", "robots", name, level=Level.WARNING)

    def _check_depths(self, scene: Scene) -> None:
        """Look for models and robots below the ground."""
        for model, ground in below_ground(scene, self._experiment.world.robots):
            message = f"the model '{model}' lies below '{ground}', which the robots stand on"
            self.collector.add(Code.NRP316, message, "world", "scene", level=Level.WARNING)
        for robot, top_m, ground in buried(scene, self._experiment.world.robots):
            message = f"the robot '{robot}' reaches up to z {top_m:.3g} m, which is below '{ground}'"
            self.collector.add(Code.NRP316, message, "world", "robots", robot, level=Level.WARNING)

    def _check_light(self) -> None:
        renderer = getattr(self.world.options, "renderer", None) if self.world else None
        if self.scene is None or self.scene.lights or renderer != "realistic":
            return
        if any(isinstance(sensor, Camera) for _, link in self.scene.links() for sensor in link.sensors):
            message = "the scene has no light: images of the realistic renderer are dark"
            self.collector.add(Code.NRP295, message, "world", "scene", level=Level.WARNING)

    def _check_drives(self, scene: Scene) -> None:
        """Make the servo of each drive, as an engine does when it opens the scene."""
        for model in scene.models:
            keys = ("world", "robots", model.name)
            is_robot = model.name in self._experiment.world.robots
            with self.collector.during(Code.NRP209, *(keys if is_robot else ("world", "scene"))):
                for drive in planar_drives(model):
                    servo_of(model, drive, bodies_of(model), scene.gravity)

    def _wrong_drives(self, scene: Scene) -> Iterator[tuple[str, str]]:
        step_s = seconds(self._experiment.timestep)
        for model in scene.models:
            if model.name in self._experiment.world.robots:
                doubts = (*implausible_drives(model, step_s), *weightless_wheels(model, scene.gravity))
                yield from ((model.name, sentence) for sentence in doubts)

    def _check_event_names(self) -> None:
        events = self._experiment.events
        for keys, name in event_references(self._experiment):
            if name not in events:
                message = f"there is no event '{name}'{did_you_mean(name, events)}"
                self.collector.add(Code.NRP213, message, *keys)

    def _brain_fits(self) -> bool:
        """Return whether the brain backend accepts the network; collect its deviations as findings."""
        if self.brain is None or self.network is None:
            return False
        name, before = self._experiment.brain.backend, len(self.collector.findings)
        check_capabilities(self._experiment, self.brain.capabilities, self.collector)
        with self.collector.during(Code.NRP216, "brain", "backend"):
            self.brain.capabilities.require(self.network, name)
            with self.collector.during(Code.NRP350, "brain", "model"), named(name, "accept the network"):
                self.collector.place(
                    Findings(
                        self.brain.backend.warnings(self.network, self.brain.options), general=Code.NRP217
                    ),
                    *("brain", "model"),
                )
                suspicious = Findings(implausible(self.network), general=Code.NRP297)
                self.collector.place(suspicious, "brain", "model")
                remarks = Findings(self.network.remarks, general=Code.NRP308)
                self.collector.place(remarks, "brain", "model")
        return not has_errors(self.collector.findings[before:])

    def _check_together(self) -> None:
        """Set everything up as for a run, with mocks that make the same checks as engines."""
        own = self._own_topics()
        if self.scene is None or own is None:
            return
        world: MockWorld | None = None
        with self.collector.during(Code.NRP209, "world", "robots"):
            world = MockWorld(engine=MockEngine(self.scene, topics=own))
        if world is None:
            self.scene = None  # no world can be made of it
        elif declare_own(self._experiment, world, self.collector):
            Watch(self._experiment, world, self.collector)
            if self.network is not None:
                before = len(self.collector.findings)
                self._check_functions(self.network, world)
                if not self.network.populations:
                    self._name_cause(before)

    def _name_cause(self, before: int) -> None:
        """Replace the errors of devices on a brain without cells by one about its file."""
        found = self.collector.findings[before:]
        others = [one for one in found if (one.code, one.level) != (Code.NRP211, Level.ERROR)]
        if len(others) < len(found):
            self.collector.findings[before:] = others
            model = self._experiment.brain.model
            is_other = model in self._experiment.transfer_functions
            doubt = "it is a file of transfer functions" if is_other else "is it the file of the brain?"
            message = f"{model.name} makes no cells, and devices of transfer functions use some: {doubt}"
            self.collector.add(Code.NRP211, message, "brain", "model")

    def _own_topics(self) -> Sequence[TopicInfo] | None:
        """Return the topics that belong to the world, not to its scene; None if an option is wrong."""
        if self.world is None:
            return ()
        name = self._experiment.world.backend
        with self.collector.during(Code.NRP206, "world", "options"), named(name, "report its topics"):
            return self.world.backend.topics(self.world.options)
        return None

    def _check_functions(self, network: Network, world: World) -> None:
        with self.collector.during(Code.NRP216, "brain", "backend"):
            brain = MockBrain(
                network, capabilities=self.brain.capabilities if self.brain and self._fits else None
            )
            warn_of_missing_topics(self.collector, self._experiment, world, self.functions)
            declare_topics(self.functions, world)
            for function in self.functions:
                self.collector.findings += doubtful_mappings(function, network)
            variables: dict[str, Any] = {}
            bound: list[TransferFunction] = []
            for function in self.functions:
                left_out = Omission(Code.NRP272, "transfer function", function.name)
                omission = None if self._experiment.strict else left_out
                with self.collector.during(Code.NRP210, "transfer_functions", omission=omission):
                    require_new_name(function, bound)
                    bound.append(function.bind(brain, world, variables=variables))
            for function in bound:
                function.unbind()
            self.functions = tuple(bound)


def event_references(experiment: Experiment) -> Iterator[tuple[tuple[Key, ...], str]]:
    """Yield every place where an experiment names an event, with the name."""
    for name, event in experiment.events.items():
        if event.when is not None and event.when.event is not None:
            yield ("events", name, "when", "event"), event.when.event
    for name, criterion in experiment.criteria.items():
        if criterion.within_of is not None:
            yield ("criteria", name, "within_of", "event"), criterion.within_of.event
        for kind in ("stays_within", "topic_stays"):
            stays = getattr(criterion, kind)
            for key in ("since", "until") if stays is not None else ():
                moment = getattr(stays.during, key)
                if isinstance(moment, str) and moment not in (START, END):
                    yield ("criteria", name, kind, "during", key), moment
