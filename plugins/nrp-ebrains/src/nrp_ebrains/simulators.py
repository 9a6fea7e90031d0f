"""The simulators that scripts of ``py_sim`` engines drive: MuJoCo, Bullet, OpenSim and Gymnasium."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from nrp_core.clock import NS_PER_S, from_seconds, seconds
from nrp_core.errors import ExperimentError, did_you_mean


def _require(name: Any, known: Collection[str], what: str) -> None:
    """Raise ExperimentError unless a name is known."""
    if name not in known:
        raise ExperimentError(f"there is no {what} '{name}'{did_you_mean(name, known)}")


class Simulator(ABC):
    """A simulator as scripts see it, ``self.sim_manager``."""

    @abstractmethod
    def run_step(self, action: Any, timestep_ns: int) -> Any:
        """Apply an action and advance by a time."""

    @abstractmethod
    def get_model_properties(self, datapack_type: str) -> Any:
        """Return the names of the objects of a kind."""

    @abstractmethod
    def get_model_property(self, datapack_name: Any, datapack_type: str) -> Any:
        """Return a property of one object."""

    @abstractmethod
    def get_model_all_properties(self, datapack_type: str) -> Any:
        """Return a property of all objects of a kind."""

    @abstractmethod
    def get_sim_time(self) -> float:
        """Return simulated time, s."""

    @abstractmethod
    def reset(self) -> Any:
        """Return to the start."""

    def shutdown(self) -> None:
        """End."""


class MujocoSimulator(Simulator):
    """MuJoCo, with the names of mujoco_py.

    A step takes ``int(timestep / model step)`` steps of MuJoCo. Properties are named as in mujoco_py:
    ``site_xpos`` of a site, ``joint_qpos`` of a joint, ``body_xpos`` of a body.
    """

    _OBJECTS = "body", "joint", "geom", "site", "actuator", "sensor", "camera", "light", "tendon"
    _COUNTS: ClassVar = {"joint": "njnt", "actuator": "nu", "camera": "ncam"}
    """The attributes with the numbers of objects, such as ``nbody`` for bodies."""

    def __init__(self, world: Path, step_s: float) -> None:
        import mujoco

        self._mujoco = mujoco
        self._model = mujoco.MjModel.from_xml_path(str(world))
        self._data = mujoco.MjData(self._model)
        self._step_ns = from_seconds(self._model.opt.timestep)
        if from_seconds(step_s) < self._step_ns:
            raise ExperimentError(
                f"the time step of the engine is shorter than that of {world.name}, "
                f"{self._model.opt.timestep:g} s"
            )

    def run_step(self, action: Any, timestep_ns: int) -> None:
        self._data.ctrl[:] = action
        self._mujoco.mj_step(self._model, self._data, timestep_ns // self._step_ns)

    def get_model_properties(self, datapack_type: str) -> tuple[str, ...]:
        type_, n = self._kind(datapack_type)
        return tuple(self._mujoco.mj_id2name(self._model, type_, i) or "" for i in range(n))

    def get_model_property(self, datapack_name: Any, datapack_type: str) -> Any:
        thing, _, quantity = datapack_type.partition("_")
        type_, _ = self._kind(thing)
        _require(str(datapack_name), self.get_model_properties(thing), thing)
        number = self._mujoco.mj_name2id(self._model, type_, str(datapack_name))
        if thing == "joint":
            return self._of_joint(number, quantity)
        view = getattr(self._data, thing)(number)
        values = getattr(view, quantity, None)
        if values is None:
            raise ExperimentError(f"a {thing} has no '{quantity}' here")
        return values.reshape(3, 3).copy() if quantity == "xmat" else values.copy()

    def _of_joint(self, number: int, quantity: str) -> Any:
        """Return a property of a joint; that of a hinge or slide is a number."""
        values = getattr(self._data.joint(number), quantity)
        return float(values[0]) if values.size == 1 else values.copy()

    def get_model_all_properties(self, datapack_type: str) -> Any:
        values = getattr(self._data, datapack_type, None)
        if values is None:
            raise ExperimentError(f"MuJoCo has no data '{datapack_type}'")
        return values.copy()

    def _kind(self, kind: str) -> tuple[Any, int]:
        _require(kind, self._OBJECTS, "kind")
        type_ = getattr(self._mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
        return type_, getattr(self._model, self._COUNTS.get(kind, f"n{kind}"))

    def get_sim_time(self) -> float:
        return float(self._data.time)

    def reset(self) -> int:
        self._mujoco.mj_resetData(self._model, self._data)
        return 0


_JOINT = {
    "index": 0, "controlMode": "POSITION_CONTROL", "targetPosition": 0, "targetVelocity": 0, "force": 0,
    "positionGain": 1, "velocityGain": 1, "maxVelocity": 0,
}  # fmt: skip
_FORCE = {"index": 0, "forceObj": (0, 0, 0), "posObj": (0, 0, 0), "flags": "LINK_FRAME"}
_TORQUE = {"index": 0, "torqueObj": (0, 0, 0), "flags": "LINK_FRAME"}


class BulletSimulator(Simulator):
    """Bullet with a plane and one URDF file; a step is one step of Bullet."""

    def __init__(self, world: Path, step_s: float) -> None:
        import pybullet
        import pybullet_data
        from pybullet_utils.bullet_client import BulletClient

        self._world, self._step_s = world, step_s
        self._bullet: Any = BulletClient(pybullet.DIRECT)
        self._constants: Any = pybullet
        self._data = pybullet_data.getDataPath()
        self._load()

    def _load(self) -> None:
        bullet = self._bullet
        bullet.setTimeStep(self._step_s)
        bullet.setGravity(0, 0, -9.8)
        bullet.setAdditionalSearchPath(self._data)
        bullet.loadURDF(str(Path(self._data) / "plane.urdf"))
        self._model = bullet.loadURDF(str(self._world))
        joints = [bullet.getJointInfo(self._model, i) for i in range(bullet.getNumJoints(self._model))]
        bodies = [bullet.getBodyInfo(i) for i in range(bullet.getNumBodies())]
        self._names = {
            "Joint": {info[1].decode(): i for i, info in enumerate(joints)},
            "Link": {info[12].decode(): i for i, info in enumerate(joints)},
            "Body": {info[1].decode(): i for i, info in enumerate(bodies)},
        }
        self._time_s = 0.0

    def run_step(self, action: Mapping[str, Any], timestep_ns: int) -> None:
        bullet, model = self._bullet, self._model
        bullet.setTimeStep(timestep_ns / NS_PER_S)
        for given in action.get("Joint", ()):
            joint = {**_JOINT, **given}
            index, mode = joint.pop("index"), getattr(self._constants, joint.pop("controlMode"))
            bullet.setJointMotorControl2(model, index, controlMode=mode, **joint)
        for given in action.get("Force", ()):
            force = {**_FORCE, **given}
            flags = self._frame(force["flags"])
            bullet.applyExternalForce(model, force["index"], force["forceObj"], force["posObj"], flags)
        for given in action.get("Torque", ()):
            torque = {**_TORQUE, **given}
            flags = self._frame(torque["flags"])
            bullet.applyExternalTorque(model, torque["index"], torque["torqueObj"], flags)
        bullet.stepSimulation()
        self._time_s += timestep_ns / NS_PER_S

    def _frame(self, name: str | int) -> int:
        return name if isinstance(name, int) else int(getattr(self._constants, name))

    def get_model_properties(self, datapack_type: str) -> dict[str, int]:
        _require(datapack_type, self._names, "kind")
        return self._names[datapack_type]

    def get_model_property(self, datapack_name: Any, datapack_type: str) -> Any:
        numbers = self.get_model_properties(datapack_type)
        _require(datapack_name, numbers, datapack_type)
        return self._read(datapack_type, numbers[datapack_name])

    def get_model_all_properties(self, datapack_type: str) -> list[Any]:
        return [self._read(datapack_type, i) for i in self.get_model_properties(datapack_type).values()]

    def _read(self, kind: str, i: int) -> Any:
        if kind == "Joint":
            return self._bullet.getJointState(self._model, i)
        if kind == "Link":
            return self._bullet.getLinkState(self._model, i)
        return self._bullet.getDynamicsInfo(i, -1)

    def get_sim_time(self) -> float:
        return self._time_s

    def reset(self) -> int:
        self._bullet.resetSimulation()
        self._load()
        return 0

    def shutdown(self) -> None:
        if self._bullet.isConnected():
            self._bullet.disconnect()


class GymnasiumSimulator(Simulator):
    """An environment of Gymnasium, which starts anew when an episode ends."""

    _PROPERTIES = ("observation", "reward", "truncated", "doneFlag", "trainInfo")

    def __init__(self, environment: str) -> None:
        try:
            import gymnasium
        except ModuleNotFoundError:
            raise ExperimentError(
                "an engine with the simulator OpenAI needs Gymnasium: pip install gymnasium"
            ) from None
        self._environment: Any = gymnasium.make(environment)
        self._values: dict[str, Any] = dict.fromkeys(self._PROPERTIES)
        self._time_s = 0.0
        self.reset()

    def run_step(self, action: Any, timestep_ns: int) -> bool:
        self._time_s += timestep_ns / NS_PER_S
        observation, reward, terminated, truncated, info = self._environment.step(action)
        done = bool(terminated or truncated)
        values = observation, float(reward), bool(truncated), done, info
        self._values = dict(zip(self._PROPERTIES, values, strict=True))
        if done:
            self._values["observation"], _ = self._environment.reset()
        return done

    def get_model_properties(self, datapack_type: str) -> list[str]:
        _require(datapack_type, ["Property"], "kind")
        return list(self._PROPERTIES)

    def get_model_property(self, datapack_name: Any, datapack_type: str) -> Any:
        _require(datapack_type, ["Property"], "kind")
        _require(datapack_name, self._PROPERTIES, "property")
        value = self._values[datapack_name]
        return value.tolist() if hasattr(value, "tolist") else value

    def get_model_all_properties(self, datapack_type: str) -> dict[str, Any]:
        _require(datapack_type, ["Property"], "kind")
        return dict(self._values)

    def get_sim_time(self) -> float:
        return self._time_s

    def reset(self) -> Any:
        self._values["observation"], self._values["trainInfo"] = self._environment.reset(seed=0)
        return self._values["observation"]

    def shutdown(self) -> None:
        self._environment.close()


class OpensimSimulator(Simulator):
    """A model of OpenSim; an action excites its muscles, with a number for each in the order of the file.

    Fibres and tendons are in balance at the start, which NRP-core 4 leaves to the first step. A ``Joint`` is
    a coordinate, by its name or that of a joint without others, and a ``Force`` the tendon of a muscle, N.
    """

    _ACCURACY: ClassVar = 5e-5

    def __init__(self, world: Path, step_s: float) -> None:
        try:
            from nrp_world_opensim.options import OpensimOptions
            from nrp_world_opensim.simulation import Simulation
        except ModuleNotFoundError:
            raise ExperimentError(
                "an engine with the simulator Opensim needs OpenSim: pip install nrp-world-opensim"
            ) from None
        self._simulation = Simulation(world, OpensimOptions(accuracy=self._ACCURACY))
        alone = {name: held[0] for name, held in self._simulation.joints().items() if len(held) == 1}
        coordinates = {name: name for name in self._simulation.coordinates}
        self._kinds: dict[str, Mapping[str, Any]] = {
            "Joint": {**alone, **coordinates},
            "Force": self._simulation.muscles,
        }

    def run_step(self, action: Any, timestep_ns: int) -> None:
        muscles = self._kinds["Force"]
        if len(action) != len(muscles):
            raise ExperimentError(
                f"the model has {len(muscles)} muscles, but the action has {len(action)} values"
            )
        self._simulation.set_controls(list(muscles), np.asarray(action, float))
        self._simulation.step(timestep_ns)

    def get_model_properties(self, datapack_type: str) -> list[str]:
        _require(datapack_type, self._kinds, "kind")
        return list(self._kinds[datapack_type])

    def get_model_property(self, datapack_name: Any, datapack_type: str) -> float:
        names = self.get_model_properties(datapack_type)
        _require(datapack_name, names, datapack_type)
        if datapack_type == "Force":
            return float(self._simulation.muscle_states([datapack_name])[2, 0])
        states = self._simulation.joint_states()
        return float(states.positions[states.names.index(self._kinds["Joint"][datapack_name])])

    def get_model_all_properties(self, datapack_type: str) -> list[float]:
        names = self.get_model_properties(datapack_type)
        return [self.get_model_property(name, datapack_type) for name in names]

    def get_sim_time(self) -> float:
        return seconds(self._simulation.time_ns)

    def reset(self) -> None:
        self._simulation.reset()


def open_simulator(config: Mapping[str, Any], folder: Path) -> Simulator:
    """Open the simulator that an engine names; its windows are not shown.

    Args:
        config: the settings of the engine.
        folder: the folder of relative paths.

    Raises:
        ExperimentError: it is not supported, or its world does not exist.
    """
    kind, world = str(config.get("Simulator", "")), str(config.get("WorldFileName", ""))
    step_s = float(config.get("EngineTimestep", 0.01))
    if kind == "OpenAI":
        return GymnasiumSimulator(world)
    kinds: dict[str, Callable[[Path, float], Simulator]] = {
        "Mujoco": MujocoSimulator, "Bullet": BulletSimulator, "Opensim": OpensimSimulator,
    }  # fmt: skip
    if kind not in kinds:
        raise ExperimentError(
            f"the simulator '{kind}' of py_sim is not supported; valid: Bullet, Mujoco, OpenAI, Opensim"
        )
    path = folder / world
    if not path.is_file():
        raise ExperimentError(f"the world file '{world}' of the engine does not exist")
    return kinds[kind](path, step_s)
