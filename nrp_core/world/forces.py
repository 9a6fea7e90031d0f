"""Forces that users apply to bodies and joints for a limited time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nrp_core.scene.model import Model
from nrp_core.scene.rigid import Wrench
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part


@dataclass(frozen=True, slots=True)
class Push:
    """A wrench on a link (at its centre of mass), or an effort on a joint, from one time to another."""

    model: str
    name: str
    load: Wrench | float
    start_ns: int
    end_ns: int | None


class ForcesPart(Part):
    """Sums the forces on each link and joint, and ends each at its time.

    The sum of the efforts on a joint stays within the limit of the joint's effort, as in Gazebo.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._pushes: list[Push] = []
        self._turning: set[tuple[str, str, bool]] = set()

    def add(self, push: Push, now_ns: int) -> None:
        """Add a force."""
        self._pushes.append(push)
        self._update({_key(push)}, now_ns)

    def clear(self, model: str, name: str, kind: type, now_ns: int) -> None:
        """End all wrenches on a link, or all efforts on a joint."""
        ended = {push for push in self._pushes if _key(push) == (model, name, kind is Wrench)}
        self._pushes = [push for push in self._pushes if push not in ended]
        self._update({(model, name, kind is Wrench)}, now_ns)

    def forget(self, model: str) -> None:
        """Remove the forces on a deleted model."""
        self._pushes = [push for push in self._pushes if push.model != model]
        self._turning = {key for key in self._turning if key[0] != model}

    def at_deadline(self, now_ns: int) -> None:
        keys = self._turning | {_key(push) for push in self._pushes if _changes(push, now_ns)}
        self._pushes = [push for push in self._pushes if push.end_ns is None or push.end_ns > now_ns]
        self._update(keys, now_ns)

    def reset(self) -> None:
        keys = {_key(push) for push in self._pushes}
        self._pushes = []
        self._update(keys, 0)

    def save(self) -> object:
        return list(self._pushes), self.deadline_ns

    def restore(self, saved: Any) -> None:
        before = {_key(push) for push in self._pushes}
        pushes, deadline_ns = saved
        self._pushes = list(pushes)
        # forces that act now began before the next deadline
        now_ns = deadline_ns - 1 if deadline_ns is not None else max((p.start_ns for p in pushes), default=0)
        self._update(before | {_key(push) for push in pushes}, now_ns)
        self.deadline_ns = deadline_ns

    def _update(self, keys: set[tuple[str, str, bool]], now_ns: int) -> None:
        for key in sorted(keys):
            acting = [p.load for p in self._pushes if _key(p) == key and p.start_ns <= now_ns]
            model, name, is_wrench = key
            if is_wrench:
                wrenches = [load for load in acting if isinstance(load, Wrench)]
                turns = self._engine.set_wrench(model, name, _total(wrenches))
                (self._turning.add if turns else self._turning.discard)(key)
            else:
                efforts = [load for load in acting if not isinstance(load, Wrench)]
                limit = _effort_limit(self._engine.scene.model(model), name)
                self._engine.set_joint_effort(model, name, min(max(sum(efforts), -limit), limit))
        times = [t for p in self._pushes for t in (p.start_ns, p.end_ns) if t is not None and t > now_ns]
        times += [now_ns + self._engine.step_ns] if self._turning else []
        self.deadline_ns = min(times, default=None)


def _key(push: Push) -> tuple[str, str, bool]:
    return push.model, push.name, isinstance(push.load, Wrench)


def _changes(push: Push, now_ns: int) -> bool:
    return push.start_ns <= now_ns or (push.end_ns is not None and push.end_ns <= now_ns)


def _effort_limit(model: Model, coordinate: str) -> float:
    """Return the limit of the effort of a joint, by a name of its coordinates."""
    return next(joint.effort for joint in model.joints if coordinate in joint.coordinates)


def _total(wrenches: list[Wrench]) -> Wrench:
    fx, fy, fz = (sum(w.force[i] for w in wrenches) for i in range(3))
    tx, ty, tz = (sum(w.torque[i] for w in wrenches) for i in range(3))
    return Wrench((fx, fy, fz), (tx, ty, tz))
