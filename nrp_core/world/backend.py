"""World backends, which are entry points of the group ``nrp_core.world``.

A backend builds an :class:`~nrp_core.world.engine.Engine`. The minimum is to step, reset, report poses of
models and accept a body velocity. The core supplies images, topics, messages, rates, time-outs, odometry,
controllers and services for all backends; see :class:`~nrp_core.world.world.World`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import ClassVar, final

from pydantic import ConfigDict

from nrp_core._support.checked_arguments import checks_arguments, require_kind
from nrp_core._support.diagnosis import Diagnosis
from nrp_core._support.plain_numbers import PlainNumbers
from nrp_core.scene.model import Scene
from nrp_core.world.batch import WorldBatch
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.domain_randomization import draw_scene
from nrp_core.world.engine import Engine
from nrp_core.world.topics import TopicInfo
from nrp_core.world.world import World

WORLD_INTERFACE_VERSION = 2
"""Version of the interface of world backends; a backend class carries it as ``interface_version``."""


class WorldOptions(PlainNumbers):
    """Base of a backend's options, as an experiment file gives them; unknown names are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class WorldBackend(ABC):
    """The entry point of a physics engine; importing and constructing it is cheap.

    Attributes:
        interface_version: the version of the interface that it implements; by default the first.
        options: the class of its options.
    """

    interface_version: ClassVar[int] = 1
    options: ClassVar[type[WorldOptions]] = WorldOptions

    @abstractmethod
    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        """Return the capabilities of the backend under these options; does not load the engine."""

    @abstractmethod
    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        """Load a scene into the engine, at time 0."""

    def fit(
        self, options: WorldOptions, scene: Scene, period_ns: int | None = None
    ) -> tuple[WorldOptions, str]:
        """Return the options with which a scene is opened, and how they differ from the values of its file.

        Args:
            options: the given options.
            scene: the scene.
            period_ns: the time step of the loop, ns; None without a loop.
        """
        return options, ""

    def refusals(self, scene: Scene) -> Iterator[tuple[str, str]]:
        """Yield the models that engines refuse in spite of the capabilities, each with the reason."""
        yield from ()

    def topics(self, options: WorldOptions) -> Sequence[TopicInfo]:
        """Return the topics that engines add to those of the scene, for the checks before a run.

        Raises:
            ExperimentError: an option is wrong.
        """
        return ()

    def another(self, first: Engine, *, seed: int, options: WorldOptions) -> Engine:
        """Open the scene of an engine again; may reuse the parts built for it."""
        return self.engine(first.scene, seed=seed, options=options)

    def diagnose(self) -> list[Diagnosis]:
        """Check this machine for the requirements of the backend; may load the engine."""
        return []

    @final
    @checks_arguments("options")
    def open(self, scene: Scene, *, seed: int, options: WorldOptions) -> World:
        """Return a world around an engine with a scene in it, at time 0."""
        require_kind(f"{type(self).__name__}.open", "options", self.options, options)
        drawn, _ = draw_scene(scene, seed)
        return _open_world(self.engine(drawn, seed=seed, options=options), scene if scene.randomize else None)

    @final
    def open_another(self, first: World, *, seed: int, options: WorldOptions) -> World:
        """Return another world with the scene of a first one, at time 0; they may share constant parts."""
        nominal = first.nominal if first.nominal.randomize else None
        if nominal is not None and (drawn := draw_scene(nominal, seed)[0]) != first.scene:
            return _open_world(self.engine(drawn, seed=seed, options=options), nominal)
        return _open_world(self.another(first.engine, seed=seed, options=options), nominal)

    @final
    def open_batch(
        self, scene: Scene, *, seeds: Sequence[int], options: WorldOptions, threads: int = 0
    ) -> WorldBatch:
        """Open a scene once for each seed; each copy behaves as it would alone.

        Args:
            scene: the scene.
            seeds: the seeds of the copies.
            options: the options of all copies.
            threads: the number of threads that step them; 0: chosen automatically.

        Raises:
            ValueError: ``seeds`` is empty.
        """
        if not seeds:
            raise ValueError("a batch needs at least one seed")

        def copies() -> Iterator[World]:
            yield (first := self.open(scene, seed=seeds[0], options=options))
            for seed in seeds[1:]:
                yield self.open_another(first, seed=seed, options=options)

        return WorldBatch.open(copies(), threads)


def _open_world(engine: Engine, nominal: Scene | None) -> World:
    """Return the world around an engine; if that fails, as when topics collide, close the engine."""
    try:
        return World(engine, nominal)
    except BaseException:
        engine.close()
        raise
