"""Joints that one topic leads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from nrp_core.world.controllers.joint import ControllerPart, Target
from nrp_core.world.engine import Engine
from nrp_core.world.rigid.motion import JointTargets


class LedTogether:
    """Leads joints of a model, firm ones with one call of the engine.

    Args:
        topic: the topic that leads them.
        parts: the controller part of each joint.
        model: their model.
        engine: the engine that moves it.
    """

    def __init__(self, topic: str, parts: Mapping[str, ControllerPart], model: str, engine: Engine) -> None:
        self._topic, self._model, self._engine = topic, model, engine
        self._joints, self._parts = tuple(parts), list(parts.values())
        self._firm = all(part.is_firm(topic) for part in self._parts)
        self._lowest, self._highest = zip(*(part.limits(topic) for part in self._parts), strict=True)
        self._values: Sequence[float] = ()
        self._rates: Sequence[float] = ()
        self._smooth = True
        self._holds = False

    def command(self, number: int) -> tuple[str, Target]:
        """Return the topic and the target of a joint that follows."""
        rate = self._rates[number] if self._rates else 0.0
        return self._topic, Target(self._values[number], rate, self._smooth)

    def lose(self) -> None:
        """One of the joints got another command."""
        self._holds = False

    def lead(
        self,
        joints: Sequence[str],
        values: Sequence[float],
        rates: Sequence[float],
        now_ns: int,
        *,
        smooth: bool,
    ) -> None:
        """Make targets the commands of joints.

        Args:
            joints: the joints; faster if these are all, in their order.
            values: their targets.
            rates: rates of change of positions; none for 0.
            now_ns: the time.
            smooth: whether the targets are approached smoothly.
        """
        if self._holds and self._joints == tuple(joints) and self._retarget(values, rates, smooth=smooth):
            return
        numbers = [self._joints.index(joint) for joint in joints]
        for number, value, rate in zip(numbers, values, rates or [0.0] * len(numbers), strict=True):
            self._parts[number].lead(self._topic, Target(value, rate, smooth), now_ns)
        if self._firm and len(numbers) == len(self._parts):
            targets = [part.target for part in self._parts]
            self._values, self._rates = [each.value for each in targets], [each.rate for each in targets]
            self._smooth = smooth
            for number, part in enumerate(self._parts):
                part.follow(self, number)
            self._holds = True

    def _retarget(self, values: Sequence[float], rates: Sequence[float], *, smooth: bool) -> bool:
        """Change the targets at once if the engine can, and if none is the first one beyond its limits."""
        given = zip(values, self._lowest, self._highest, strict=True)
        kept = [low if value < low else high if value > high else value for value, low, high in given]
        if kept != values:
            beyond = [number for number, value in enumerate(values) if kept[number] != value]
            if rates or not all(self._parts[number].has_reported(self._topic) for number in beyond):
                return False
        if not self._engine.retarget(self._model, JointTargets(self._joints, kept, rates, smooth)):
            return False
        self._values, self._rates, self._smooth = kept, rates, smooth
        return True
