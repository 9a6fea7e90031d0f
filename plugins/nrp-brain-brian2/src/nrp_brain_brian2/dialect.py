"""The module ``brian2`` for scripts, found through the entry point for dialects of PyNN."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar

from nrp_core.brain import Network
from nrp_core.errors import BackendLoadError

from nrp_brain_brian2.options import INSTALL

if TYPE_CHECKING:
    from nrp_brain_brian2.script import FirstRun


class Dialect:
    """The module ``brian2`` of a script: Brian2 builds the network, another backend runs it.

    Args:
        pynn: the simulator of PyNN in the same script.
        run: called instead of ``run`` with the network and the duration in s; by default the script ends.
    """

    runner: ClassVar[str] = "brian2"

    def __init__(self, pynn: ModuleType, run: Callable[[FirstRun, float], None] | None = None) -> None:
        self._pynn, self._run = pynn, run
        self._module: ModuleType | None = None
        self._end: FirstRun | None = None

    @property
    def library_names(self) -> Mapping[str, Any]:
        """The names of PyNN's library, unchanged."""
        return vars(self._pynn)

    def module(self, name: str) -> ModuleType | None:
        """Return ``brian2``; other modules are Brian2's own.

        Raises:
            BackendLoadError: Brian2 is not installed.
        """
        if name != "brian2":
            return None
        if find_spec(name) is None:
            raise BackendLoadError("Brian2 is not installed in this Python", remedy=INSTALL)
        self._module = self._module or self._with_run()
        return self._module

    def _with_run(self) -> ModuleType:
        import brian2

        from nrp_brain_brian2.script import FirstRun, begin, first_run

        begin()
        module = ModuleType(brian2.__name__, brian2.__doc__)
        vars(module).update(vars(brian2))

        def ended(call: Callable[..., object], duration: Any, *given: Any, **options: Any) -> None:
            try:
                with first_run():
                    call(duration, *given, **options)
            except FirstRun as end:
                self._end = end
                if self._run is None:
                    raise
            if self._run is not None and self._end is not None:
                self._run(self._end, float(duration))

        def run(duration: Any, *given: Any, level: int = 0, **options: Any) -> None:
            ended(brian2.run, duration, *given, level=level + 2, **options)

        class Network(brian2.Network):  # type: ignore[misc]
            def run(self, duration: Any, *given: Any, level: int = 0, **options: Any) -> None:
                ended(super().run, duration, *given, level=level + 2, **options)

        def set_device(*_: Any, **__: Any) -> None:
            """Let the backend run the network, regardless of Brian2's device."""

        vars(module).update(run=run, Network=Network, set_device=set_device)
        return module

    def missing(self, _name: str, _importer: Mapping[str, Any]) -> ModuleType | None:
        """Return None: other modules are the script's own affair."""
        return None

    def network(self, _variables: Mapping[str, Any]) -> Network | None:
        """Return the network that the script has built at its first ``run``; None if it never runs.

        Raises:
            CapabilityError, NetworkError: only Brian2 can run it.
        """
        if self._end is None:
            return None
        from nrp_brain_brian2.neutral import network_of
        from nrp_brain_brian2.script import built_of

        return network_of(built_of(self._end))
