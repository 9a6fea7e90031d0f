"""Leaky integrators that trigger functions, as those of the platform did on SpiNNaker."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds
from nrp_core.dsl.devices.devices import Device, LeakyIntegratorDevice, Port
from nrp_core.dsl.devices.kinds import DeviceKind
from nrp_core.dsl.parameters.binding import Binding
from nrp_core.dsl.selection.selection import Selection

_STEP_MS = 1.0
"""The time step of a machine whose network does not set another."""


class SendingIntegrator(LeakyIntegratorDevice):
    """A leaky integrator that sends its voltage each time a number of time steps of its network has passed.

    Args:
        timesteps: this number.
    """

    __slots__ = ("_brain", "_period_ns", "_sent", "_timesteps")

    options: ClassVar[tuple[str, ...]] = ("timesteps",)

    def __init__(
        self,
        parameter: str,
        port: Port,
        selection: Selection,
        release: Callable[[], None],
        *,
        timesteps: float = 10,
    ) -> None:
        super().__init__(parameter, port, selection, release)
        if not timesteps >= 1:
            raise ValueError(f"timesteps must be 1 or more, not {timesteps}")
        self._timesteps = int(timesteps)
        self._sent = 0

    def attach(self, brain: Brain) -> None:
        """Follow the time of a brain."""
        self._brain = brain
        self._period_ns = from_milliseconds(self._timesteps * (brain.network.timestep_ms or _STEP_MS))
        self.refresh(brain.now_ns)

    def has_news(self) -> bool:
        return self._brain.now_ns // self._period_ns > self._sent

    def refresh(self, now_ns: int) -> None:
        self._sent = now_ns // self._period_ns

    def reset(self) -> None:
        self._sent = 0

    def save(self) -> Any:
        return self._sent

    def restore(self, saved: Any) -> None:
        self._sent = saved


class SendingKind(DeviceKind):
    """A kind of leaky integrator that can trigger functions."""

    __slots__ = ()

    def open(
        self, binding: Binding, selection: Selection, options: Mapping[str, Any], *, parameter: str, name: str
    ) -> Device:
        device = super().open(binding, selection, options, parameter=parameter, name=name)
        assert isinstance(device, SendingIntegrator)
        device.attach(binding.brain)
        return device


def sending(kind: DeviceKind) -> SendingKind:
    """Return a kind of leaky integrator whose devices can trigger functions."""
    return SendingKind(kind.name, kind.spec, SendingIntegrator, kind.defaults)
