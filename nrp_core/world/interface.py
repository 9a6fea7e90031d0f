"""The world side: what a physics engine must offer to take part in the loop.

A minimal backend steps its engine, resets it, tells where models are and takes a body velocity: the abstract
``_do_*`` methods of :class:`~nrp_core.world.engine.PhysicsEngine`. Pictures, topics, messages, rates,
time-outs, odometry, controllers and services are supplied here, once for all backends, by the parts in
:mod:`nrp_core.world.parts` and the :mod:`~nrp_core.world.switchboard`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import BaseModel, ConfigDict

from nrp_core._support.diagnosis import Diagnosis
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError, DivergedError, SceneError, TimestepError, did_you_mean
from nrp_core.simulation import Simulation
from nrp_core.world.capabilities import WorldCapabilities as WorldCapabilities
from nrp_core.world.capabilities import needs_of
from nrp_core.world.changes import Changeable, change
from nrp_core.world.drives.drive import DrivePart
from nrp_core.world.engine import PhysicsEngine
from nrp_core.world.forces import ForcesPart
from nrp_core.world.messages.std_msgs import ColorRGBA
from nrp_core.world.model_states import StatesPart
from nrp_core.world.part import Part
from nrp_core.world.parts import parts_of
from nrp_core.world.render.cameras import ImageArray as ImageArray
from nrp_core.world.rigid.motion import ModelMotion
from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.merged_bodies import body_of
from nrp_core.world.scene.model import Light, Model, Rgba, Scene
from nrp_core.world.services.gazebo import Services
from nrp_core.world.switchboard import Switchboard
from nrp_core.world.topics import Stamped, check_message
from nrp_core.world.visuals import ColorPart

if TYPE_CHECKING:
    from nrp_core.world.batch import WorldBatch

WORLD_INTERFACE_VERSION = 1
"""Version of this interface; a backend class carries the one it was written for as ``interface_version``."""


class WorldOptions(BaseModel):
    """Base of a backend's options, as an experiment file gives them; unknown names are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class World(Simulation, Switchboard, PhysicsEngine, Changeable):
    """A scene in a physics engine, at a time.

    Args:
        scene: what is simulated.
        seed: the experiment's seed for the world.
        capabilities: what the backend has.
        identity: text that names backend and options.

    Attributes:
        scene: what is simulated now; models may have come, gone or moved since it was opened.
        forces: what users let act on bodies and joints.
        paused: while this is true, time goes on but nothing moves.
        warnings: what was noticed.
    """

    def __init__(self, scene: Scene, *, seed: int, capabilities: WorldCapabilities, identity: str) -> None:
        Simulation.__init__(self, seed=seed, identity=f"{identity},scene {scene.digest}")
        Switchboard.__init__(self, capabilities.step_ns)
        PhysicsEngine.__init__(self, scene, capabilities)
        Changeable.__init__(self)
        self._require_movable(scene)
        self._opened = scene
        self.paused = False
        self.warnings: list[str] = list(scene.warnings)
        self.forces = ForcesPart(self)
        self._services = Services(self)
        self._world_parts: list[Part] = [StatesPart(self), self._services, self.forces]
        self._model_parts: dict[str, list[Part]] = {}
        for part in self._world_parts:
            self._serve(part)
        self._take_stock()

    # -- the scene while it runs

    @change
    def call(self, service: str, /, *values: Any, **fields: Any) -> Any:
        """Call a service, such as ``/gazebo/set_model_state``, and return its answer.

        Args:
            service: its name.
            values: the fields of its request in their order, or the request itself.
            fields: the fields by name.

        Raises:
            TopicError: there is no such service, or the request does not fit.
        """
        self._require_ready()
        name = self._info(service).name
        request = self._services.request(name, values, fields)
        check_message(self._info(name), request)
        with self._guarded(f"answer {name}"):
            answer = self._services.answer(name, request)
        for observer in self._observers:
            observer(name, Stamped(self._now_ns, request))
        return answer

    @change
    def spawn(self, model: Model) -> None:
        """Add a model, whose topics are served from now on.

        Raises:
            SceneError: there is a model of that name, or it contradicts itself.
            CapabilityError: the engine cannot do that.
        """
        scene = self.scene.with_model(model)
        for part in parts_of(model, self):
            for topic in part.topics:
                self._require_free(topic.name)
        self._change_scene(scene)
        for part in self._model_parts[model.name] if self._started else ():
            part.begin()

    @change
    def delete(self, model: str) -> None:
        """Take a model out; who listens to its topics hears nothing more.

        Raises:
            SceneError: there is no such model.
            CapabilityError: the engine cannot do that.
        """
        gone = self.scene.model(model)
        self.forces.forget(gone.name)
        self._change_scene(self.scene.without(gone.name))

    @change
    def place(self, model: str, motion: ModelMotion) -> None:
        """Put a model somewhere; what does not float is held there and does not move.

        Raises:
            SceneError: there is no such model, or where it is to be is not finite.
            CapabilityError: the engine cannot do that.
        """
        told = (*motion.pose.position, *motion.pose.orientation, *motion.linear, *motion.angular)
        if not all(map(isfinite, told)):
            raise SceneError(f"'{model}' cannot be put where numbers are not finite: {motion}")
        if self._floats(model):
            self._do_place(model, motion)
            self._drive_on(model)
        elif self.scene.model(model).pose != motion.pose:
            self._change_scene(self.scene.with_pose(model, motion.pose))

    @change
    def set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        """Put joints of a model at positions (rad, m), at rest.

        Raises:
            SceneError: there are no such joints, or a position is not finite.
            CapabilityError: the engine cannot do that.
        """
        known = [name for joint in self.scene.model(model).joints for name in joint.coordinates]
        for name, position in positions.items():
            if name not in known:
                raise SceneError(f"'{model}' has no joint '{name}' that moves{did_you_mean(name, known)}")
            if not isfinite(position):
                raise SceneError(f"the joint '{name}' of '{model}' cannot be put at {position}")
        self._do_set_joints(model, positions)
        self._drive_on(model)

    @change
    def set_material(self, visual: str, rgba: Rgba, glows: bool | None = None) -> None:
        """Give a visual a colour, and say whether it has that in any light.

        Args:
            visual: its path, ``model/link/visual``.
            rgba: the colour, 0..1.
            glows: as realistic pictures show it; None: as before.
        """
        topic = f"/{visual}/color"
        self.advertise(topic).publish(ColorRGBA(*rgba))
        part = self._parts[topic]
        if glows is not None and isinstance(part, ColorPart):
            part.set_glow(glows)

    @change
    def set_lights(self, lights: Iterable[Light]) -> None:
        """Let these be the lights of the scene; realistic pictures show them, flat ones do not."""
        self.scene = replace(self.scene, lights=tuple(lights))
        self._do_set_lights(self.scene.lights)

    @change
    def set_gravity(self, gravity: Vector) -> None:
        """Let things fall otherwise from now on, m/s^2.

        Raises:
            SceneError: it is not finite.
            CapabilityError: the engine cannot do that.
        """
        if not all(map(isfinite, gravity)):
            raise SceneError(f"gravity is three finite numbers, not {gravity}")
        if gravity != self.scene.gravity:
            self._change_scene(replace(self.scene, gravity=gravity))

    @change
    def return_home(self) -> None:
        """Put every model and its joints where they were at first, at rest; time and commands stay."""
        homes = {model.name: model.pose for model in self._opened.models}
        for model in self.scene.models:
            pose = homes.get(model.name, model.pose)
            if not model.static:
                self.place(model.name, ModelMotion(pose))
                names = self._do_joint_states(model.name).names
                self._do_set_joints(model.name, dict.fromkeys(names, 0.0))
            elif model.pose != pose:
                self.place(model.name, ModelMotion(pose))

    @change
    def start_over(self) -> None:
        """Let everything be as it was when the world was opened, commands and colours too; only time goes on.

        Raises:
            CapabilityError: the engine cannot do that.
        """
        if not self.capabilities.changes:
            raise self._lacks("cannot start over while time goes on")
        self._start_over()
        for part in self._all_parts if self._started else ():
            part.begin()

    def _start_over(self) -> None:
        if self.scene is not self._opened:
            self._load_scene(self._opened)
        self._do_reset(self._seed)
        for part in self._all_parts:
            part.reset()

    def _drive_on(self, model: str) -> None:
        """Let the drives of a model that was put elsewhere aim at what is commanded, from there."""
        for part in self._model_parts[model]:
            if isinstance(part, DrivePart):
                part.restore(part.save())

    def _floats(self, model: str) -> bool:
        bodies = self._bodies_of(model)
        return bodies[body_of(bodies, self.scene.model(model).links[0].name)].floats

    def _change_scene(self, scene: Scene) -> None:
        """Load another scene and put what is in both back to where it is."""
        if not self.capabilities.changes:
            raise self._lacks("cannot change its scene")
        stay = {model.name for model in scene.models}
        kept = {m.name: self._do_configuration(m.name) for m in self._moving if m.name in stay}
        commands = [(part, part.save()) for part in self._all_parts]
        self._load_scene(scene)
        for name, configuration in kept.items():
            self._do_configure(name, configuration)
        for part, saved in commands:
            if part in self._all_parts:
                part.restore(saved)

    def _load_scene(self, scene: Scene) -> None:
        if replace(self.scene, lights=scene.lights) == scene:
            self.scene = scene
            self._do_set_lights(scene.lights)
            return
        self._require_movable(scene)
        self._do_load(scene)
        self.scene = scene
        self._forget_scene()
        self._take_stock()

    def _require_movable(self, scene: Scene) -> None:
        """Refuse a scene in which something would move in a way that the engine does not have."""
        has = self.capabilities
        for model in scene.models:
            if not (has.dynamics or model.static or model.drives):
                raise self._lacks(f"has no dynamics: '{model.name}' could not move; make it static")
            for joint in model.joints if has.dynamics and not model.static else ():
                for need in needs_of(joint):
                    if not getattr(has, need):
                        what = f"has no {need.replace('_', ' ')}, as '{model.name}/{joint.name}' is one"
                        raise self._lacks(what)

    def _take_stock(self) -> None:
        """Serve the parts of the models that are there now, and no others."""
        scene = self.scene
        self._moving = [model for model in scene.models if not model.static]
        for name in [name for name in self._model_parts if name not in {m.name for m in scene.models}]:
            for part in self._model_parts.pop(name):
                self._withdraw(part)
        for model in scene.models:
            if model.name not in self._model_parts:
                self._model_parts[model.name] = parts = list(parts_of(model, self))
                for part in parts:
                    self._serve(part)
        named = [part for model in scene.models for part in self._model_parts[model.name]]
        self._all_parts = [*self._world_parts, *named]
        self._timed_parts = [
            part for part in self._all_parts if type(part).at_deadline is not Part.at_deadline
        ]

    # -- the sequence of one advance, the same for every backend

    def _advance(self, t_ns: int) -> None:
        step_ns = self.capabilities.step_ns
        if t_ns % step_ns:
            raise TimestepError(
                f"{milliseconds(t_ns):g} ms is no multiple of the world's step, {milliseconds(step_ns):g} ms"
            )
        if not self._started:
            self._started = True
            for part in self._all_parts:
                part.begin()
            self._sample()
        while self._at_ns < t_ns:
            stop_ns = self._next_stop(t_ns)
            self._step_engine((stop_ns - self._at_ns) // step_ns)
            self._at_ns = stop_ns
            for part in self._timed_parts if not self.paused else ():
                deadline_ns = part.deadline_ns
                if deadline_ns is not None and deadline_ns <= stop_ns:
                    part.at_deadline(stop_ns)
            self._sample()
        self._check_finite(t_ns)

    def _step_engine(self, steps: int) -> None:
        """Let so many physics steps pass, in which nothing moves while the world is paused."""
        if not self.paused:
            self._do_advance(steps)

    def _next_stop(self, t_ns: int) -> int:
        step_ns = self.capabilities.step_ns
        due_ns = self._next_due()
        stop_ns = t_ns if due_ns is None else min(t_ns, due_ns)
        for part in self._timed_parts if not self.paused else ():
            deadline_ns = part.deadline_ns
            if deadline_ns is not None and deadline_ns < stop_ns:
                on_grid_ns = -(-deadline_ns // step_ns) * step_ns
                stop_ns = min(stop_ns, max(on_grid_ns, self._at_ns + step_ns))
        return stop_ns

    def _check_finite(self, t_ns: int) -> None:
        for model in self._moving:
            if not all(map(isfinite, self.model_motion(model.name).pose.position)):
                message = f"model '{model.name}' is nowhere: its position is not finite"
                raise DivergedError(message, t_ns=t_ns)

    def _write(self, part: Part, topic: str, message: Any) -> None:
        with self._guarded(f"take a message on {topic}"):
            part.write(topic, message, self._now_ns)

    # -- reset and snapshots

    def _reset(self) -> None:
        self._at_ns = 0
        self._started = False
        self.paused = False
        self._plan_samples()
        self._forget_messages()
        self._start_over()

    def _save(self) -> object:
        self._require_snapshot()
        changed = None if self.scene is self._opened else self.scene
        parts = [part.save() for part in self._all_parts]
        time = self._seed, self._at_ns, self._started, self.paused
        return time, changed, self._kept_messages(), parts, self._do_save()

    def _load(self, saved: Any) -> None:
        self._require_snapshot()
        (self._seed, self._at_ns, self._started, self.paused), changed, kept, parts, state = saved
        scene = self._opened if changed is None else changed
        if scene != self.scene:
            self._load_scene(scene)
        self._plan_samples()
        self._do_restore(state)
        for part, state_of in zip(self._all_parts, parts, strict=True):
            part.restore(state_of)
        self._refill(kept)

    def _require_snapshot(self) -> None:
        if not self.capabilities.snapshot:
            raise CapabilityError(f"{type(self).__name__} cannot save and restore its state")


class WorldBackend(ABC):
    """The entry point of a physics engine; importing and constructing it is cheap.

    Attributes:
        interface_version: the version of this interface it was written for; the first, if it does not say.
        options: the model of its options.
    """

    interface_version: ClassVar[int] = 1
    options: ClassVar[type[WorldOptions]] = WorldOptions

    @abstractmethod
    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        """Return what the backend has under these options; does not load the engine."""

    def diagnose(self) -> list[Diagnosis]:
        """Look at this machine for what the backend needs; may load the engine."""
        return []

    @abstractmethod
    def open(self, scene: Scene, *, seed: int, options: WorldOptions) -> World:
        """Load a scene into the engine, at time 0."""

    def open_batch(
        self, scene: Scene, *, seeds: Sequence[int], options: WorldOptions, threads: int = 0
    ) -> WorldBatch:
        """Open a scene many times, once for each seed; each copy does what it would do alone.

        Args:
            scene: what is simulated.
            seeds: of the copies.
            options: of all copies.
            threads: how many step them; 0: as many as help.

        Raises:
            ValueError: there are no seeds.
        """
        from nrp_core.world.batch import WorldBatch  # which needs this module

        if not seeds:
            raise ValueError("a batch needs at least one seed")

        def copies() -> Iterator[World]:
            yield (first := self.open(scene, seed=seeds[0], options=options))
            for seed in seeds[1:]:
                yield self._open_again(first, seed=seed, options=options)

        return WorldBatch.open(copies(), threads)

    def _open_again(self, first: World, *, seed: int, options: WorldOptions) -> World:
        """Open once more what was just opened; a backend may use what it has built for the first."""
        return self.open(first.scene, seed=seed, options=options)
