"""Make the parts of an experiment from its file, with the values of their parameters.

A reader of another format has its own :class:`Maker` if a part is not simply a file in our format.

An entry point in ``nrp_core.networks``, named by a suffix or, for native scripts, by a backend, is a
function ``read(path, populations=..., seed=...)`` that returns a :class:`~nrp_core.network.data.Network`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from hashlib import blake2b
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, TypeAlias, TypeVar

from nrp_core._support.kept_readings import KeptReadings
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.loading import Listing
from nrp_core.errors import ExperimentError, NetworkError, SceneError, UnknownBackendError, did_you_mean
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Build, Experiment, PartMaker
from nrp_core.experiment.model.section import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.network.data import Network
from nrp_core.network.groups import SEPARATOR, join_networks
from nrp_core.network.picking import Selection
from nrp_core.parameters import FUNCTIONS, Declared, Parameter, Value, fitting, read_parameters
from nrp_core.registry import Registry
from nrp_core.scene.clearance import with_clearance
from nrp_core.scene.model import Model, Scene, files_behind
from nrp_core.scene.reading.context import FindElsewhere, read_without
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.seeds import Seeds
from nrp_core.world.robot_setup import set_up_robot

READERS: Registry[Callable[..., Network]] = Registry("nrp_core.networks", "reader of networks")


def network_from(
    path: Path,
    *,
    populations: Mapping[str, Selection] | None = None,
    seed: int = 0,
    parameters: Mapping[str, object] | None = None,
    simulator: str = "",
) -> Network:
    """Read a brain script or any other file with an installed reader.

    Args:
        path: the file.
        populations: names for neurons of its circuit.
        seed: the seed of its random numbers.
        parameters: values of the parameters that a script declares; only such a reader gets them.
        simulator: the backend with the simulator in which a native script runs.

    Raises:
        NetworkError: no reader supports the file, or it cannot be read.
        NeuronSelectionError: ``populations`` reaches outside the circuit.
        CapabilityError: it contains elements that networks do not support.
    """
    kind = simulator or path.suffix
    if kind not in READERS.names() and not READERS.distribution_with(kind):
        valid = did_you_mean(kind, [one for one in READERS.names() if one.startswith(".") == (not simulator)])
        what = "native scripts run on the backend" if simulator else "network is read from files that end in"
        raise NetworkError(f"no {what} '{kind}'{valid}", path=path)
    try:
        read = READERS.load(kind)
    except UnknownBackendError as error:
        raise NetworkError(str(error), path=path) from error
    given = {"parameters": parameters} if parameters else {}
    return read(path, populations=populations, seed=seed, **given)


def _networks_from(*paths: Path, groups: Sequence[str], seed: int, **values: Mapping[str, Any]) -> Network:
    """Read several networks as the groups of one; each draws from its own seed, see :func:`network_from`."""
    networks = {}
    for group, path in zip(groups, paths, strict=True):
        begin = f"{group}{SEPARATOR}"
        own: dict[str, Any] = {
            key: {name.removeprefix(begin): one for name, one in every.items() if name.startswith(begin)}
            for key, every in values.items()
        }
        networks[group] = network_from(path, seed=Seeds(seed).child("model").integer(group), **own)
    return join_networks(networks)


Loader: TypeAlias = Callable[..., list[TransferFunction]]
Lister: TypeAlias = Callable[[Path], Listing]

LOADERS: Registry[Loader] = Registry("nrp_core.transfer_functions", "loader of transfer functions")
LISTERS: Registry[Lister] = Registry("nrp_core.transfer_function_listings", "reader of transfer functions")


def build_here(make: Callable[[], Network]) -> Network:
    """Make a network in this process."""
    return make()


Read = TypeVar("Read", bound=Scene | Model)


def _is_from_text(whole: Scene | Model) -> bool:
    """Return whether Python read all that is behind a room or robot; MuJoCo and caches of meshes hide it."""
    models = whole.models if isinstance(whole, Scene) else (whole,)
    return not any(model.native for model in models) and not any(files_behind(whole))


_READINGS: Final[KeptReadings[Any]] = KeptReadings(128, _is_from_text)
"""The rooms and robots that were read: the runs of a sweep share them."""


class Maker(PartMaker):
    """Makes each part from the file that the experiment names; subclasses replace methods for others.

    Attributes:
        find_elsewhere: finds meshes and images that are missing at their path; None: do not search.
    """

    find_elsewhere: FindElsewhere | None = None

    def room(self, experiment: Experiment) -> Scene:
        """Return the scene without robots, empty without a file; if not strict, without unusable parts.

        Raises:
            SceneError: it cannot be read.
        """
        path = experiment.world.scene
        return Scene(()) if path is None else self._read(experiment, read_scene, path)

    def robot(self, experiment: Experiment, name: str) -> Model:
        """Return a robot; if the experiment is not strict, without unusable parts.

        Raises:
            SceneError: it cannot be read.
        """
        section = experiment.world.robots[name]
        assert section.model is not None, "a robot of the scene's file is read with the room"
        args = {"name": name, "pose": section.start, "args": section.args}
        return _fit(experiment, name, self._read(experiment, read_model, section.model, **args))

    def _read(self, experiment: Experiment, read: Callable[..., Read], path: Path, **args: Any) -> Read:
        """Read a room or a robot, or return it as an earlier experiment of this process has read it."""
        models = experiment.models
        read_all = partial(read, path, search_path=models, find_elsewhere=self.find_elsewhere, **args)

        def read_now() -> Read:
            if experiment.strict:
                return read_all()
            part, left_out = read_without(lambda without: read_all(without=without, lenient=True))
            return replace(part, warnings=(*part.warnings, *left_out))

        if self.find_elsewhere is not None:
            return read_now()
        found: Read = _READINGS.get((read, path, tuple(models), experiment.strict, repr(args)), read_now)
        return found

    def network(self, experiment: Experiment, build: Build = build_here) -> Network:
        brain, files = experiment.brain, experiment.brain.files
        given: dict[str, Any] = {
            "populations": brain.populations, "seed": experiment.seed, "parameters": brain.parameters,
        }  # fmt: skip
        if "" in files:
            simulator = brain.backend if brain.native else ""
            return build(partial(network_from, files[""], simulator=simulator, **given))
        return build(partial(_networks_from, *files.values(), groups=tuple(files), **given))

    def functions(self, experiment: Experiment, collector: Collector) -> Iterator[TransferFunction]:
        for i, path in enumerate(experiment.transfer_functions):
            with collector.during(Code.NRP210, "transfer_functions", i):
                yield from load_function_file(path, experiment.function_parameters)

    def listings(self, experiment: Experiment, collector: Collector) -> Iterator[Listing]:
        for i, path in enumerate(experiment.transfer_functions):
            with collector.during(Code.NRP210, "transfer_functions", i):
                if _suffix(path) in LISTERS.names():
                    yield LISTERS.load(path.suffix)(path)
                else:
                    message = f"'{path.name}' is known only when it runs"
                    collector.add(Code.NRP239, message, "transfer_functions", i, level=Level.NOTE)


def maker_of(experiment: Experiment) -> PartMaker:
    """Return the maker of an experiment: its own, or the one for our formats."""
    return experiment.maker or Maker()


def scene_of(experiment: Experiment) -> Scene:
    """Return the room of an experiment with its robots, as its files describe them.

    Raises:
        SceneError: the file of the room or of a robot cannot be read.
    """
    maker = maker_of(experiment)
    scene = maker.room(experiment)
    for name in experiment.world.robots:
        scene = with_robot(scene, experiment, name, maker)
    return with_clearance(scene)


def with_robot(scene: Scene, experiment: Experiment, name: str, maker: PartMaker) -> Scene:
    """Return a scene with a robot of an experiment, or with additions to a model that it has.

    Raises:
        SceneError: the robot cannot be read, or the scene already has a model of its name, or has none for a
            robot without a file.
    """
    section, names = experiment.world.robots[name], [model.name for model in scene.models]
    if section.model is None:
        if name not in names:
            hint = did_you_mean(name, names)
            raise SceneError(f"'{name}' needs the key 'model', because the scene has no model '{name}'{hint}")
        own = scene.model(name)
        placed = own if section.start is None else replace(own, pose=section.start)
        found = _fit(experiment, name, replace(placed, warnings=()))
        models = tuple(found if model is own else model for model in scene.models)
        return replace(scene, models=models, warnings=(*scene.warnings, *found.warnings))
    if name in names:
        other = "; for a robot in the scene's file leave 'model' out"
        raise SceneError(f"the room already has a model '{name}': rename the robot, or the model{other}")
    return scene.with_model(maker.robot(experiment, name))


def _fit(experiment: Experiment, name: str, model: Model) -> Model:
    """Return a robot with the experiment's additions; findings about these refer to the experiment."""
    result = set_up_robot(model, experiment.world.robots[name].fitting)
    place = experiment.place("world", "robots", name)
    warnings = [
        one if one.path else replace(place.finding(one.code, one.message, one.level), subject=one.subject)
        for one in result.warnings
    ]
    return replace(result, warnings=tuple(warnings))


def load_function_file(
    path: Path, parameters: Mapping[str, object] = MappingProxyType({})
) -> list[TransferFunction]:
    """Return the transfer functions of a file of any supported kind.

    Args:
        path: the file.
        parameters: values of parameters; a loader gets those that its file declares.

    Raises:
        ExperimentError: the kind is not supported, or the file is invalid.
    """
    loader = LOADERS.load(_suffix(path))
    declared = read_parameters(path, FUNCTIONS).parameters if parameters else ()
    given = {name: parameters[name] for name in declared if name in parameters}
    functions = loader(path, parameters=given) if given else loader(path)
    origin = path.resolve(), blake2b(path.read_bytes() + repr(sorted(given.items())).encode()).digest()
    for function in functions:
        function.origin = origin
    return functions


def _suffix(path: Path) -> str:
    """Return the registered suffix of a file."""
    if path.suffix not in LOADERS.names():
        valid = did_you_mean(path.suffix, LOADERS.names())
        raise ExperimentError(f"no transfer functions are read from '{path.name}'{valid}")
    return path.suffix


@dataclass(frozen=True, slots=True)
class ParameterValue:
    """A parameter of a script and its value in an experiment.

    Args:
        parameter: its declaration.
        value: in the declared unit.
        set_by: where the experiment sets it, such as ``experiment.yaml:5``; None: it is the default.
    """

    parameter: Parameter
    value: Value
    set_by: str | None = None

    @classmethod
    def of_data(cls, name: str, data: Mapping[str, Any]) -> ParameterValue:
        """Return the parameter that :meth:`as_data` described."""
        file = data["file"] and Path(data["file"])
        about = {key: data[key] for key in ("default", "unit", "low", "high", "doc", "line")}
        by_whom = data.get("set_by", "the experiment" if data["value"] != data["default"] else None)
        return cls(Parameter(name.rpartition(SEPARATOR)[2], path=file, **about), data["value"], by_whom)

    def __str__(self) -> str:
        """Return value, range and description in one line."""
        about = [self.parameter.range, self.parameter.doc]
        if self.set_by is not None:
            about.insert(0, f"default {self.parameter.value_text(self.parameter.default)}")
        details = "; ".join(filter(None, about))
        return f"{self.parameter.name} = {self.parameter.value_text(self.value)}" + (
            f"  ({details})" if details else ""
        )

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        one = self.parameter
        return {
            "value": self.value, "default": one.default, "unit": one.unit, "low": one.low, "high": one.high,
            "doc": one.doc, "file": one.path and one.path.name, "line": one.line, "set_by": self.set_by,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Parameters:
    """All parameters of an experiment, by name.

    Args:
        brain: those of its brain script.
        functions: those of its transfer functions.
    """

    brain: Mapping[str, ParameterValue] = field(default_factory=dict)
    functions: Mapping[str, ParameterValue] = field(default_factory=dict)

    def as_data(self) -> dict[str, dict[str, Any]]:
        """Return them as plain data for JSON."""
        sides = {"brain": self.brain, "functions": self.functions}
        return {side: {name: one.as_data() for name, one in all_.items()} for side, all_ in sides.items()}

    def given_to(self, experiment: Experiment) -> Experiment:
        """Return an experiment with those of these values that are set."""
        brain = experiment.brain.model_copy(update={"parameters": _plain_values(self.brain)})
        functions = _plain_values(self.functions)
        return experiment.model_copy(update={"brain": brain, "function_parameters": functions})


def with_parameters(experiment: Experiment, collector: Collector) -> tuple[Experiment, Parameters]:
    """Check the parameters of an experiment without executing a script.

    Returns:
        the experiment without the values that do not fit, which are findings, and all parameters.
    """
    maker, brain = maker_of(experiment), experiment.brain
    of_brain = _check_values(
        maker.brain_parameters(experiment), brain.parameters, collector, "brain", "parameters"
    )
    of_functions = _check_values(
        maker.function_parameters(experiment),
        experiment.function_parameters,
        collector,
        "function_parameters",
    )
    parameters = Parameters(of_brain, of_functions)
    return parameters.given_to(experiment), parameters


def _check_values(
    declared: Declared, given: Mapping[str, object], collector: Collector, *keys: Key
) -> dict[str, ParameterValue]:
    for mistake in declared.mistakes:
        with collector.during(Code.NRP202):
            raise mistake
    for parameter in () if declared.mistakes else declared.unused:
        message = f"nothing reads the parameter '{parameter.name}': every value gives the same result"
        where = Finding(Code.NRP279, message, Level.WARNING, parameter.path, parameter.line)
        collector.findings.append(where)
    values, wrong = fitting(declared.parameters, given)
    unread = {mistake.path for mistake in declared.mistakes}
    for name, message in wrong.items():
        if name in declared.parameters or not unread:  # an unreadable declaration may be the one for it
            collector.add(Code.NRP202, message, *keys, *name.split(SEPARATOR))
    return {
        name: ParameterValue(
            one,
            values[name],
            str(collector.source.place_of(*keys, *name.split(SEPARATOR)))
            if name in given and name not in wrong
            else None,
        )
        for name, one in declared.parameters.items()
    }


def _plain_values(parameters: Mapping[str, ParameterValue]) -> dict[str, Value]:
    return {name: one.value for name, one in parameters.items() if one.set_by is not None}
