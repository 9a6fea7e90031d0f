"""An observable of a body."""

from __future__ import annotations

from nrp_core.observables import Observable, Surroundings


class Momentum(Observable):
    """The magnitude of the momentum of a model's links as if they moved together, kg m/s."""

    unit = "kg m/s"

    def __init__(self, around: Surroundings, of: str) -> None:
        model = around.world.scene.model(of)
        self._engine, self._model = around.world.engine, model.name
        self._mass = sum(link.inertial.mass for link in model.links if link.inertial is not None)
        self.name = f"the momentum of {model.name}"

    def value(self, now_ns: int) -> float:
        velocity = self._engine.model_motion(self._model).linear
        return float(self._mass * sum(v * v for v in velocity) ** 0.5)
