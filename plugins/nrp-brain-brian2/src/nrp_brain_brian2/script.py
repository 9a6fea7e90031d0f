"""Execute a script of Brian2 up to its first ``run``. Importing this loads Brian2."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any

import brian2
import numpy as np
from brian2.core.names import Nameable
from brian2.core.network import Network as Brian2Network
from brian2.devices.device import Device, get_device, runtime_device
from brian2.groups.subgroup import Subgroup
from nrp_core.brain import IntArray
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.scripts import BuildingEnds, Scope

from nrp_brain_brian2.options import NAME

_SEEDS = 2**32
_OWN = ("brian2.", "nrp_brain_brian2.")
"""The code between a script's call of ``run`` and the network's."""


@dataclass(frozen=True)
class Built:
    """What a script had built when it called ``run``.

    Args:
        network: Brian2's network, which has not run.
        namespace: the variables around the call, which its equations use.
        groups: the groups that emit spikes or have cells, by the names of their variables.
        views: global ids of the cells of subgroups, by the names of their variables.
    """

    network: Any
    namespace: Mapping[str, Any]
    groups: Mapping[str, Any]
    views: Mapping[str, IntArray]


class FirstRun(BuildingEnds):
    """Ends the script at its first ``run``.

    Args:
        network: Brian2's network.
        namespace: the variables that the call gives to its equations, or None.

    Attributes:
        frames: the frames of the script, from the call to the module.
    """

    def __init__(self, network: Any, namespace: Any) -> None:
        self.network, self.namespace = network, namespace
        self.frames: list[FrameType] = []


def execute(path: Path, seed: int, *, compiled: bool = False) -> Built:
    """Execute a script up to its first ``run``.

    Args:
        path: the script.
        seed: the seed of Brian2's random numbers.
        compiled: whether Brian2 compiles, unless the script chooses its target.

    Raises:
        NetworkError: the script raises, or ends without ``run``; with file and line.
        CapabilityError: it chooses a device that cannot stop between steps.
    """
    scope, module = Scope((), lambda _: None), ModuleType(path.stem)
    begin(compiled=compiled)
    brian2.seed(seed % _SEEDS)
    arguments, sys.argv = sys.argv, [str(path)]
    try:
        with first_run():
            scope.run(path, module, name="__main__")
    except FirstRun as end:
        return built_of(end)
    except (Exception, SystemExit) as error:
        raise scope.located(error, NetworkError, path) from error
    finally:
        sys.argv = arguments
        if get_device() is not runtime_device:
            brian2.set_device("runtime")
    raise NetworkError("the script ends without run(), which ends the building of its network", path=path)


def begin(*, compiled: bool = False) -> None:
    """Let the script find Brian2 as in a new process."""
    brian2.prefs.reset_to_defaults()
    brian2.prefs.codegen.target = "cython" if compiled else "numpy"
    for name in ("method_choice", "unused_brian_object"):
        brian2.BrianLogger.suppress_name(name)
    Nameable.__instances__().clear()  # default names begin anew, because Brian2 orders objects by name
    runtime_device.defaultclock = brian2.Clock(dt=0.1 * brian2.ms, name="defaultclock")
    brian2.start_scope()


@contextmanager
def first_run() -> Iterator[None]:
    """Let the first run of any network of Brian2 raise :class:`FirstRun`, and refuse other devices."""
    originals, own = (Brian2Network.run, Device.activate), os.getpid()

    def end(self: Any, *_: Any, namespace: Any = None, **__: Any) -> None:
        if os.getpid() != own:
            raise CapabilityError("the script calls run() in another process, which a loop cannot step")
        ending = FirstRun(self, namespace)
        frame: FrameType | None = sys._getframe(1)
        while frame is not None and str(frame.f_globals.get("__name__")).startswith(_OWN):
            frame = frame.f_back
        while frame is not None:
            ending.frames.append(frame)
            frame = None if frame.f_code.co_name == "<module>" else frame.f_back
        raise ending

    def activate(self: Any, *given: Any, **options: Any) -> None:
        if self is not runtime_device:
            raise CapabilityError(f"{NAME}'s standalone mode cannot stop between steps; remove set_device")
        originals[1](self, *given, **options)

    Brian2Network.run, Device.activate = end, activate
    try:
        yield
    finally:
        Brian2Network.run, Device.activate = originals


def built_of(end: FirstRun) -> Built:
    """Return the network of a script with the names of its groups."""
    caller, network = end.frames[0], end.network
    namespace = end.namespace or {**caller.f_globals, **caller.f_locals}
    objects = list(network.objects)
    if isinstance(network, brian2.MagicNetwork):  # it is one for all scripts of a process
        schedule, network = network.schedule, Brian2Network()
        network.schedule = schedule
        for one in objects:
            one._network = None
        network.add(objects)
    kinds = (brian2.NeuronGroup, brian2.core.spikesource.SpikeSource)  # a subgroup may be an object, too
    groups = {id(one): one for one in objects if isinstance(one, kinds) and not isinstance(one, Subgroup)}
    named: dict[str, Any] = {}
    views: dict[str, Any] = {}
    for name, value in _variables(end.frames):
        if isinstance(value, Subgroup):
            views[name] = value
        elif id(value) in groups:
            named.setdefault(name, groups.pop(id(value)))
    rest = sorted(groups.values(), key=lambda one: (len(one.name), one.name))
    named.update((one.name, one) for one in rest)
    first, offsets = 0, {}
    for group in named.values():
        offsets[group.name] = first
        first += len(group)
    found = {
        name: np.arange(one.start, one.stop) + offsets[one.source.name]
        for name, one in views.items()
        if one.source.name in offsets and name not in named
    }
    return Built(network, namespace, named, found)


def _variables(frames: list[FrameType]) -> Iterator[tuple[str, Any]]:
    """Yield names and values: variables from the module to the call, and members of lists among them."""
    for frame in reversed(frames):
        local = dict(frame.f_locals)
        local |= vars(local["self"]) if hasattr(local.get("self"), "__dict__") else {}
        for name, value in local.items():
            yield name, value
            if isinstance(value, list | tuple):
                yield from ((f"{name}_{i}", one) for i, one in enumerate(value))
            elif isinstance(value, dict):
                yield from ((f"{name}_{key}", one) for key, one in list(value.items()))


def scale_of(variable: Any) -> float:
    """Return the value in SI of one mV, nA or uS of a variable of Brian2; 1 for other dimensions."""
    for unit, scale in ((brian2.volt, 1e-3), (brian2.amp, 1e-9), (brian2.siemens, 1e-6)):
        if variable.dim is unit.dim:
            return scale
    return 1.0
