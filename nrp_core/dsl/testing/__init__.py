"""Mocks and a test rig for transfer functions, without simulators."""

from __future__ import annotations

from nrp_core.dsl.testing.mocks import MockBrain, MockWorld
from nrp_core.dsl.testing.rig import Rig

__all__ = ["MockBrain", "MockWorld", "Rig"]
