"""The experiment file as typed data; its keys, units and defaults are documented here.

:func:`nrp_core.experiment.reading.find.load_experiment` reads one; one made in Python is equivalent.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    JsonValue,
    PlainValidator,
    PrivateAttr,
    StrictInt,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.overview import Overview, Row
from nrp_core.cle.pacing import SLOWEST
from nrp_core.clock import NS_PER_MS, milliseconds, seconds
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.loading import Listing
from nrp_core.dsl.messages import message_type
from nrp_core.errors import did_you_mean
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.event_schema import END, START, Criterion, Event, ObservableForm
from nrp_core.experiment.model.randomize_schema import RandomizeSection
from nrp_core.experiment.model.section import (
    NAME_PATTERN,
    Key,
    Name,
    Place,
    PoseList,
    Range,
    Section,
    TopicName,
    Tree,
    identifier,
)
from nrp_core.experiment.model.variant_schema import InterventionSection, WiringControl
from nrp_core.findings import Code
from nrp_core.findings.removed_codes import removed_in
from nrp_core.network.data import Network
from nrp_core.parameters import BRAIN, FUNCTIONS, Declared, read_in_groups, read_parameters
from nrp_core.paths import ExistingFile, ExistingFolder, existing_file
from nrp_core.quantities import AngleRad, DurationNs, LengthM, PeriodNs, RateHz, RoundedNs, time_ns
from nrp_core.scene.devices import Pid
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.reading.context import SHIPPED
from nrp_core.scene.rigid import Pose
from nrp_core.seeds import require_seed
from nrp_core.world.robot_setup import AddedSensor, JointControl, RobotSetup
from nrp_core.world.world import World


class AddedSensorSection(Section):
    """A sensor on a link of a robot; further keys are the elements of SDF's ``<sensor>``."""

    model_config = ConfigDict(extra="allow")

    __pydantic_extra__: dict[str, JsonValue]

    type: str
    """Its type in SDF: ``camera``, ``lidar``, ``imu``, ``contact`` and so on."""
    link: str
    """The link that holds it; for a ``force_torque`` the joint that it measures."""
    name: str = ""
    """Unique on its link; by default its type."""
    pose: PoseList = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """On its link: x, y, z, roll, pitch, yaw."""
    rate: RateHz = Field(default=30.0, gt=0)
    """Messages per second."""

    @property
    def sensor(self) -> AddedSensor:
        """The same for a scene."""
        x, y, z, roll, pitch, yaw = self.pose
        pose = Pose.from_rpy((x, y, z), roll, pitch, yaw)
        settings: dict[str, Any] = dict(self.__pydantic_extra__ or {})
        return AddedSensor(self.type, self.link, self.name, pose, self.rate, settings)


_SLICE = re.compile(r"-?\d*:-?\d*(:-?\d*)?")
_SHORTEST_LIMIT_NS = NS_PER_MS
"""A shorter limit would interrupt calls that only start slowly."""


def _selection(value: object) -> str | int | list[int]:
    match value:
        case str() if _SLICE.fullmatch(value):
            return str(value)
        case int() if not isinstance(value, bool):
            return value
        case list() if all(isinstance(item, int) for item in value):
            return value
    raise ValueError(f"neurons are '0:5', '0:6:2', 3 or [0, 2], not {value!r}")


def _pace(value: object) -> str | float:
    if value in ("max", "realtime"):
        return str(value)
    if isinstance(value, (int, float)) and not isinstance(value, bool) and SLOWEST <= value < float("inf"):
        return float(value)
    raise ValueError(f"a pace is 'max', 'realtime' or a factor of at least {SLOWEST:g}, not {value!r}")


def _parameter(value: object) -> object:
    """Check a value of a parameter by its type only; the script's declaration determines the valid values."""
    match value:
        case bool() | int() | float():
            return value
        case str():
            return str(value)
        case list() if all(isinstance(one, (int, float, str)) for one in value):
            return [str(one) if isinstance(one, str) else one for one in value]
    raise ValueError(f"a value is a number, a text, true, false or a list of numbers, not {value!r}")


def _limit(value: object) -> object:
    try:
        limit_ns = None if value in (None, "off") else time_ns(value)
    except ValueError as error:
        raise ValueError(f"{error}; or 'off' for no limit") from None
    if limit_ns is not None and limit_ns < _SHORTEST_LIMIT_NS:
        raise ValueError(f"a time limit is at least 1 ms, or 'off', not {value!r}")
    return limit_ns


def _models(value: object) -> Path | dict[str, Path]:
    if isinstance(value, Mapping) and value:
        return {identifier(name): existing_file(file) for name, file in value.items()}
    return existing_file(value)


def _by_group(value: object) -> object:
    """Return values by their names with those of their groups: ``{red: {gain: 2}}`` sets ``red.gain``."""
    if not isinstance(value, Mapping):
        return value
    every = {name: one if isinstance(one, Mapping) else {"": one} for name, one in value.items()}
    return {
        f"{group}.{name}" if name else group: one
        for group, values in every.items()
        for name, one in values.items()
    }


def _grouped(name: str) -> str:
    for part in str(name).split("."):
        identifier(part)
    return name


BrainModel = Annotated[
    Path | dict[str, Path],
    PlainValidator(_models),
    WithJsonSchema(
        {"type": ["string", "object"], "description": "a file, relative to the file that names it"}
    ),
]
Selection = Annotated[
    str | int | list[int],
    PlainValidator(_selection),
    WithJsonSchema({"type": ["string", "integer", "array", "object"], "examples": ["0:5", 3, [0, 2]]}),
]
ByGroup = BeforeValidator(_by_group)
GroupedName = Annotated[str, AfterValidator(_grouped), Field(json_schema_extra={"pattern": NAME_PATTERN})]
Pace = Annotated[
    str | float,
    PlainValidator(_pace),
    WithJsonSchema({"type": ["string", "number"], "examples": ["max", "realtime", 2.0]}),
]
TimeLimit = Annotated[
    int | None,
    BeforeValidator(_limit),
    WithJsonSchema({"type": ["string", "number"], "examples": ["60 s", "off"]}),
]
ParameterValue = Annotated[
    bool | int | float | str | list[float | str],
    PlainValidator(_parameter),
    WithJsonSchema(
        {
            "type": ["boolean", "number", "string", "array", "object"],
            "examples": [1.5, "1.5 mV", True, [0.1, 0.2]],
        }
    ),
]
MessageType = Annotated[
    type, PlainValidator(message_type), WithJsonSchema({"type": "string", "examples": ["std_msgs/Float64"]})
]
VariedRange = Annotated[
    Range, PlainValidator(Range.parse), WithJsonSchema({"type": "string", "examples": ["4..8 s"]})
]


class BackendSection(Section):
    """The backend of one side, and its options."""

    backend: str
    """Name of an installed backend; ``nrp backends`` lists them."""
    options: dict[str, Any] = Field(default_factory=dict)
    """Options of that backend."""


class BrainSection(BackendSection):
    """The brain side."""

    model: BrainModel
    """The brain: a PyNN script, a network file (``.nrpnet``), a SONATA configuration (``.json``)
    or a trained network (``.nir``); or several by name: ``{red: a.py, blue: b.py}``."""
    native: bool = False
    """Whether the model is a script of the simulator of ``backend``, which runs in that simulator alone."""
    populations: Annotated[dict[GroupedName, Selection], ByGroup] = Field(default_factory=dict)
    """Names for groups of neurons of its ``circuit``; of a file without one, of all its neurons. With
    several models, for each by its name: ``{red: {eyes: "0:5"}}``."""
    time_limit: TimeLimit = 600_000_000_000
    """Wall time that the script may take to build the network, or ``off``."""
    parameters: Annotated[dict[GroupedName, ParameterValue], ByGroup] = Field(default_factory=dict)
    """Values of the parameters that the script declares with ``sim.parameter``; with several models, for
    each by its name."""
    controls: tuple[WiringControl, ...] = ()
    """Random changes of the wiring before the interventions: ``[rewire: degree_preserving]``."""
    interventions: tuple[InterventionSection, ...] = ()
    """Cells that are silenced, lesioned or activated, and weights that are scaled."""

    @property
    def files(self) -> dict[str, Path]:
        """The files of the models by their names; a single model has the name ``""``."""
        return self.model if isinstance(self.model, dict) else {"": self.model}

    @model_validator(mode="after")
    def _require_groups(self) -> BrainSection:
        for key in ("populations", "parameters"):
            for name in getattr(self, key):
                group, _, inner = name.rpartition(".")
                if group not in self.files:
                    models = ", ".join(f"'{one}'" for one in self.files if one) or "a single one"
                    what = f"'{inner}' is of no model" if not group else f"there is no model '{group}'"
                    raise ValueError(f"{key}.{group or inner}: {what}; the models: {models}")
        if self.native and (self.controls or any(one.change for one in self.interventions)):
            raise ValueError("controls and interventions cannot reach the synapses of a 'native' script")
        if self.native and self.parameters:
            raise ValueError("a 'native' script has no parameters; scripts of PyNN declare them")
        return self


class ControlSection(Section):
    """How joints are commanded."""

    mode: Literal["position", "velocity", "effort", "trajectory"] = "position"
    """The commanded quantity; joints with ``trajectory`` go along trajectories together."""
    p: float | None = Field(default=None, ge=0)
    """Effort for each unit of error; without gains a joint follows with any load within its limits."""
    i: float = Field(default=0.0, ge=0)
    """Effort for each unit of the error's integral."""
    d: float = Field(default=0.0, ge=0)
    """Effort for each unit of the error's rate."""
    group: Name | None = None
    """Joints of a group take one message with a number for each."""

    @model_validator(mode="after")
    def _gains_together(self) -> ControlSection:
        if self.p is None and self.model_fields_set & {"i", "d"}:
            raise ValueError("'i' and 'd' need 'p'; without gains the joint follows with any load")
        if self.mode == "effort" and self.p is not None:
            raise ValueError("an effort is applied as it is commanded, so it has no gains")
        if self.mode == "trajectory" and self.group is not None:
            raise ValueError("joints with the mode 'trajectory' are led together already, without a group")
        return self

    @property
    def control(self) -> JointControl:
        """The same for a scene."""
        gains = None if self.p is None else Pid(self.p, self.i, self.d)
        return JointControl(self.mode, gains, self.group or "")


class RobotSection(Section):
    """One robot."""

    model: ExistingFile | None = None
    """Its body: a file in SDF, URDF, xacro or another format; by default, the model in the scene."""
    pose: PoseList | None = None
    """Where it starts: x, y, z, roll, pitch, yaw; by default the pose in its file."""
    args: dict[str, str | int | float | bool] = Field(default_factory=dict)
    """Arguments of a xacro file."""
    keyframe: str = ""
    """A start that its file names, in MJCF a ``<key>``: pose, joints and targets of position controllers."""
    on_ground: bool = False
    """Whether its lowest collision is at the z of its pose, or at 0 without a pose."""
    fixed: bool | None = None
    """Whether its base is fixed to the world; by default as in its file."""
    joints: dict[str, AngleRad | LengthM] = Field(default_factory=dict)
    """Positions of joints at the start; by default 0, or the limit nearest to it."""
    control: dict[str, ControlSection] = Field(default_factory=dict)
    """How joints are commanded, by regular expressions for their names: ``".*": {mode: position}``."""
    add_sensors: tuple[AddedSensorSection, ...] = ()
    """Further sensors on its links: ``[{type: camera, link: head}]``."""

    @model_validator(mode="after")
    def _arguments_of_a_file(self) -> RobotSection:
        if self.args and self.model is None:
            raise ValueError("'args' are the arguments of a xacro file: give the file as 'model'")
        return self

    @property
    def fitting(self) -> RobotSetup:
        """What is added to its file."""
        control = tuple((pattern, section.control) for pattern, section in self.control.items())
        sensors = tuple(section.sensor for section in self.add_sensors)
        placed = self.pose is not None
        starts = tuple(self.joints.items())
        return RobotSetup(self.fixed, starts, control, sensors, self.keyframe, placed, self.on_ground)

    @property
    def start(self) -> Pose | None:
        """The initial pose, if given."""
        if self.pose is None:
            return None
        x, y, z, roll, pitch, yaw = self.pose
        return Pose.from_rpy((x, y, z), roll, pitch, yaw)


class SensorSection(Section):
    """Imperfections of a topic that the world publishes, in addition to the file of its robot."""

    noise: float | None = Field(default=None, ge=0)
    """Standard deviation of Gaussian noise on every number, in its own unit; 1 is full brightness."""
    bias: float = 0.0
    """Mean of that noise."""
    delay: DurationNs | None = None
    """From the measurement to the arrival of its message."""
    drop_out: float | None = Field(default=None, ge=0, le=1)
    """Share of the messages that get lost."""

    @model_validator(mode="after")
    def _require_a_setting(self) -> SensorSection:
        if not self.model_fields_set:
            raise ValueError(f"sets nothing; valid: {', '.join(type(self).model_fields)}")
        if "bias" in self.model_fields_set and self.noise is None:
            raise ValueError("'bias' is the mean of 'noise': give that too; 'noise: 0' for the bias alone")
        return self


class CommandSection(Section):
    """Imperfections of commands."""

    delay: DurationNs
    """From the publication of a command to its effect."""


EMPTY_SCENE = SHIPPED.parent / "empty.sdf"
"""The scene called ``empty``: a ground and a sun."""


def _scene_file(value: object) -> Path:
    """Return the file of a scene; ``empty`` is that with a ground and a sun."""
    return EMPTY_SCENE if value == "empty" else existing_file(value)


SceneFile = Annotated[
    Path,
    BeforeValidator(_scene_file),
    WithJsonSchema(
        {"type": "string", "description": "a file, relative to the file that names it; or 'empty'"}
    ),
]
"""The file of a scene, kept as an absolute path."""


class WorldSection(BackendSection):
    """The world side."""

    scene: SceneFile | None = None
    """The room: an SDF file, or ``empty``; required unless the world has its own."""
    robots: dict[Name, RobotSection] = Field(default_factory=dict)
    """The robots in it; a robot's name is that of its model in the scene."""
    sensors: dict[TopicName, SensorSection] = Field(default_factory=dict)
    """Imperfections added to sensors, by topic."""
    commands: dict[TopicName, CommandSection] = Field(default_factory=dict)
    """Imperfections of commands, by topic."""
    randomize: RandomizeSection = RandomizeSection()
    """What is drawn anew for each seed: ``{mass: {robot/base: {scale: 0.9..1.1}}}``."""


class ComparisonSection(Section):
    """Settings of ``nrp diff`` in the experiment."""

    vary: dict[str, VariedRange] = Field(default_factory=dict)
    """Settings on whose exact value the finding must not depend, drawn with the seed: ``key: 4..8 s``."""
    controls: tuple[WiringControl, ...] = ()
    """Controls of the wiring to compare with the original, each by itself: ``[shuffle: signs]``."""


class ChecksSection(Section):
    """Which findings are reported."""

    ignore: tuple[str, ...] = ()
    """Codes of warnings and notes that are not reported, such as ``NRP229``; errors always are."""

    @field_validator("ignore")
    @classmethod
    def _check_codes(cls, codes: tuple[str, ...]) -> tuple[str, ...]:
        for code in codes:
            if code not in Code.__members__ and removed_in(code) is None:
                raise ValueError(f"there is no code '{code}'{did_you_mean(code, Code.__members__)}")
        return codes


class VoltageSection(Section):
    """Samples of membrane voltages in a recording."""

    cells: tuple[Annotated[StrictInt, Field(ge=0)], ...] | None = Field(default=None, min_length=1)
    """Indices of the cells in their population or view; by default all."""
    interval: DurationNs = NS_PER_MS
    """Time between two samples; they lie on the grid of the brain."""


class RecordingSection(Section):
    """What a recording of a run contains."""

    exclude: tuple[str, ...] = ()
    """Populations whose spikes are not recorded, such as sources of noise."""
    topics: tuple[TopicName, ...] = ()
    """Topics of sensors that are recorded although nothing in the experiment subscribes to them."""
    voltages: dict[str, VoltageSection] = Field(default_factory=dict)
    """Cells whose membrane voltage is recorded, by population or view: ``{circuit: {cells: [0]}}``."""


class CompatibilitySection(Section):
    """Another platform with the names and modules that the files of this experiment use."""

    platform: str
    """Name of an installed platform: ``hbp_nrp`` is the original one."""
    options: dict[str, Any] = Field(default_factory=dict)
    """Options of that platform."""


class Experiment(Overview, Section):
    """A brain, a world, their connection, and events and criteria."""

    name: str = Field(min_length=1)
    """Name of the experiment."""
    description: str = ""
    """Description for readers."""
    timestep: PeriodNs = 20_000_000
    """Period of the closed loop; a rate or fraction, ``60 Hz`` or ``1/60 s``, is rounded to 0.1 ms."""
    duration: DurationNs
    """Simulated time of a run."""
    seed: StrictInt = 0
    """Seed of all random numbers."""
    brain: BrainSection
    """The brain side."""
    world: WorldSection
    """The world side."""
    transfer_functions: tuple[ExistingFile, ...] = ()
    """Files with transfer functions."""
    function_parameters: dict[Name, ParameterValue] = Field(default_factory=dict)
    """Values of the parameters that these files declare with ``nrp.parameter``."""
    topics: dict[TopicName, MessageType] = Field(default_factory=dict)
    """Topics of the experiment's own, with their message types."""
    aliases: dict[TopicName, TopicName] = Field(default_factory=dict)
    """More names for topics: ``alias: topic``."""
    events: dict[Name, Event] = Field(default_factory=dict)
    """Events, by name."""
    observables: dict[Name, ObservableForm] = Field(default_factory=dict)
    """Numbers that criteria, events, measures, environments and figures use, by name: ``{height: husky}``."""
    criteria: dict[Name, Criterion] = Field(default_factory=dict)
    """Criteria that must be met for the run to pass."""
    comparison: ComparisonSection = ComparisonSection()
    """How the finding is compared between simulators."""
    recording: RecordingSection = RecordingSection()
    """What a recording contains."""
    checks: ChecksSection = ChecksSection()
    """Which findings are reported."""
    on_error: Literal["stop", "quarantine"] = "stop"
    """Effect of a transfer function that raises or does not return: stop the run, or quarantine it."""
    function_time_limit: TimeLimit = 60_000_000_000
    """Wall time that one call of a transfer function may take, or ``off``; see ``on_error``."""
    tf_time: Literal["end", "start", "summed"] = "end"
    """The time for transfer functions: of their data, of the start of the step, or this as a sum of steps."""
    strict: bool = True
    """Whether a transfer function that cannot be bound, a robot or a part of the scene that cannot be
    read, or a topic that nobody serves is an error; otherwise these are left out with a warning, and the
    topic stays silent."""
    pace: Pace = "max"
    """Speed of the run: ``max``, ``realtime`` or a multiple of real time."""
    models: tuple[ExistingFolder, ...] = ()
    """Folders to search for ``model://`` and other files of rooms and robots."""
    compatibility: CompatibilitySection | None = None
    """The platform that its files were written for, if they need features that only it has."""
    csv_folder: Path = Path("csv")
    """Where a run that is not recorded puts the files of its CSV recorders."""

    _source: Tree = PrivateAttr(default_factory=lambda: Tree({}))
    _maker: PartMaker | None = PrivateAttr(default=None)
    _overrides: tuple[str, ...] = PrivateAttr(default=())

    def _overview(self) -> tuple[str, Iterable[Row]]:
        engines = f"{self.brain.backend} and {self.world.backend}"
        return f"{self.name}: {seconds(self.duration):g} s on {engines}", [
            ("part", "value"),
            *((f"brain {name}".strip(), path) for name, path in self.brain.files.items()),
            ("scene", self.world.scene or "none"),
            *((f"robot {name}", robot.model or "in the scene") for name, robot in self.world.robots.items()),
            *(("transfer functions", path) for path in self.transfer_functions),
            *((f"criterion {name}", "") for name in self.criteria),
            ("seed", self.seed),
        ]

    @field_validator("duration")
    @classmethod
    def _whole_steps(cls, duration: int, before: ValidationInfo) -> int:
        timestep = before.data.get("timestep")
        if isinstance(timestep, RoundedNs):
            return max(1, (2 * duration + timestep) // (2 * timestep)) * timestep
        if timestep and duration % timestep:
            raise ValueError(
                f"{milliseconds(duration):g} ms must be a multiple of the time step, "
                f"{milliseconds(timestep):g} ms"
            )
        return duration

    @field_validator("events")
    @classmethod
    def _free_names(cls, events: dict[str, Event]) -> dict[str, Event]:
        for name in (START, END):
            if name in events:
                raise ValueError(f"an event cannot be named '{name}': that is a point in time of every run")
        return events

    @field_validator("csv_folder")
    @classmethod
    def _folder(cls, folder: Path) -> Path:
        if folder.exists() and not folder.is_dir():
            raise ValueError(f"'{folder}' is a file, and the files of recorders need a folder")
        return folder

    def with_source(self, source: Tree) -> Experiment:
        """Return the same experiment with the places of its values."""
        copy = self.model_copy()
        copy._source = source
        return copy

    def with_seed(self, seed: int) -> Experiment:
        """Return the same experiment with another seed.

        Raises:
            ExperimentError: it is not an integer.
        """
        return self.model_copy(update={"seed": require_seed(seed)})

    def ignoring(self, codes: Sequence[str]) -> Experiment:
        """Return the same experiment that does not report some more codes of findings."""
        ignored = self.checks.model_copy(update={"ignore": (*self.checks.ignore, *codes)})
        return self.model_copy(update={"checks": ignored})

    def with_maker(self, maker: PartMaker) -> Experiment:
        """Return the same experiment with a maker of its parts."""
        copy = self.model_copy()
        copy._maker = maker
        return copy

    @checks_arguments()
    def with_overrides(self, overrides: Sequence[str]) -> Experiment:
        """Return the same experiment with the overrides ``dotted.key=value`` of its file."""
        copy = self.model_copy()
        copy._overrides = tuple(overrides)
        return copy

    def with_csv_folder(self, folder: Path) -> Experiment:
        """Return the same experiment with another folder for CSV files, unless an override names one."""
        is_named = any(one.partition("=")[0].strip() == "csv_folder" for one in self._overrides)
        return self if is_named else self.model_copy(update={"csv_folder": folder})

    @property
    def overrides(self) -> tuple[str, ...]:
        """The overrides of its file."""
        return self._overrides

    @property
    def maker(self) -> PartMaker | None:
        """The maker of its parts; None: they are files in our formats."""
        return self._maker

    @property
    def source(self) -> Tree:
        """The values as written, with places; empty for an experiment created in Python."""
        return self._source

    def place(self, *keys: Key) -> Place:
        """Return the place of a value, or of the nearest enclosing one."""
        return self._source.place_of(*keys)


Build: TypeAlias = Callable[[Callable[[], Network]], Network]
"""Builds a network by a function that can be pickled, possibly in another process."""


class PartMaker(ABC):
    """Makes the parts of an experiment."""

    @abstractmethod
    def room(self, experiment: Experiment) -> Scene:
        """Return the scene without robots.

        Raises:
            SceneError: it cannot be read.
        """

    @abstractmethod
    def robot(self, experiment: Experiment, name: str) -> Model:
        """Return a robot.

        Raises:
            SceneError: it cannot be read.
        """

    @abstractmethod
    def network(self, experiment: Experiment, build: Build = ...) -> Network:
        """Return the network of the brain.

        Args:
            experiment: the experiment.
            build: builds it; by default in this process.

        Raises:
            NetworkError: it cannot be made.
            NeuronSelectionError: a population reaches outside of it.
        """

    @abstractmethod
    def functions(self, experiment: Experiment, collector: Collector) -> Iterator[TransferFunction]:
        """Yield new transfer functions; mistakes go to the collector."""

    @abstractmethod
    def listings(self, experiment: Experiment, collector: Collector) -> Iterator[Listing]:
        """Yield the code that :meth:`functions` would execute; mistakes go to the collector."""

    def brain_parameters(self, experiment: Experiment) -> Declared:
        """Return the parameters that the brain file declares; it is not executed."""
        return read_in_groups(experiment.brain.files, lambda path: read_parameters(path, BRAIN))

    def function_parameters(self, experiment: Experiment) -> Declared:
        """Return the parameters that the files of transfer functions declare; they are not executed."""
        declared = Declared()
        for path in experiment.transfer_functions:
            read_parameters(path, FUNCTIONS, into=declared)
        return declared

    def declare_missing_topics(self, world: World, functions: Sequence[TransferFunction]) -> None:
        """Add the topics that these functions expect to a world, such as aliases."""
