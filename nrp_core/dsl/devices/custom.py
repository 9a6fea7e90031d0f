"""Custom devices, made from devices of the brain."""

from __future__ import annotations

from abc import abstractmethod
from copy import copy
from typing import Any, Self

from nrp_core.brain.devices.ports import SourcePort
from nrp_core.brain.devices.sinks import SinkPort
from nrp_core.brain.interface import Brain
from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.dsl.selection.selection import Selection


class CustomDevice(Adapter):
    """Base of custom devices; a mapping takes an instance, and the function gets a copy bound to neurons.

    ::

        class Envelope(nrp.CustomDevice):
            def apply(self, neurons, brain, tau=20.0):
                self._port = brain.add_sink(PopulationRate(tau_fall=tau), neurons.ids, name="envelope")

            @property
            def level(self):
                return self._port.rate / 100

        @nrp.MapSpikeSink("envelope", nrp.brain.cells, Envelope(), tau=50.0)

    A device that keeps values between steps returns them from ``save`` and takes them back in ``restore``;
    devices of the brain save theirs themselves.
    """

    _brain: Brain
    _ports: list[SourcePort | SinkPort]

    @abstractmethod
    def apply(self, neurons: Selection | list[Selection], brain: Brain, **settings: Any) -> None:
        """Bind the device to neurons; devices added to the brain here are removed with this device.

        Args:
            neurons: the selected neurons; a list if the selector gives one.
            brain: its ``add_source`` and ``add_sink`` make devices for neurons, given by their ``ids``.
            settings: the other arguments of the mapping.
        """

    def bound(self, neurons: Selection | list[Selection], brain: Brain, settings: dict[str, Any]) -> Self:
        """Return a copy that is bound to neurons."""
        device = copy(self)
        known = set(map(id, brain.devices))
        device._brain = brain
        try:
            device.apply(neurons, brain, **settings)
        except BaseException:
            device._take(known)
            device.release()
            raise
        device._take(known)
        return device

    def _take(self, known: set[int]) -> None:
        """Own the ports that were added to the brain since then."""
        self._ports = [port for port in self._brain.devices if id(port) not in known]

    def set_active(self, active: bool) -> None:
        for port in self._ports:
            port.active = active

    def release(self) -> None:
        for port in self._ports:
            self._brain.remove(port)
        self._ports = []
