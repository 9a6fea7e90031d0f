"""Currents that vary by themselves do so at the same times with the same values, however a run is split."""

from __future__ import annotations

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.brain.devices.sources import ACSource, CurrentPort, CurrentSpec, DCSource, NoisyCurrentSource
from nrp_core.clock import FOREVER_NS
from nrp_core.dsl.testing import MockBrain
from nrp_core.seeds import Seeds

MS = 1_000_000


class Listening(MockBrain):
    """A brain that notes which current flowed when."""

    def __init__(self) -> None:
        super().__init__({"cells": 2})
        self.flowed: list[tuple[int, tuple[float, ...]]] = []
        self.now = np.zeros(2)

    def _do_set_current(self, currents_na: np.ndarray) -> None:
        self.now = currents_na

    def _do_run_until(self, t_ns: int) -> None:
        if self.flowed and self.flowed[-1][1] == tuple(self.now):
            self.flowed.pop()
        self.flowed.append((t_ns, tuple(self.now)))


def flow(spec: CurrentSpec, stops_ms: list[int]) -> list[tuple[int, tuple[float, ...]]]:
    with Listening() as brain:
        brain.add_source(spec, [0, 1], name="current")
        for stop in stops_ms:
            brain.run_until(stop * MS)
        return brain.flowed


SPECS = [
    ACSource(amplitude=0.2, offset=0.1, frequency=25.0, phase=30.0, start=3.0),
    NoisyCurrentSource(mean=0.1, stdev=0.02, dt=2.0),
    DCSource(amplitude=0.3, start=4.0, stop=9.0),
]


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: type(spec).__name__)
@given(cuts=st.sets(st.integers(1, 39)))
def test_a_current_does_not_depend_on_how_a_run_is_split(spec: CurrentSpec, cuts: set[int]) -> None:
    assert flow(spec, [*sorted(cuts), 40]) == flow(spec, [40])


def port_of(spec: CurrentSpec, seed: int = 1) -> CurrentPort:
    port = spec.open(np.arange(2), Seeds(seed), "current")
    assert isinstance(port, CurrentPort)
    return port


def test_a_sine_begins_at_its_start_with_its_phase() -> None:
    port = port_of(ACSource(amplitude=2.0, offset=1.0, frequency=10.0, phase=90.0, start=5.0, dt=0.001))
    assert port.current_na(4_999_000).tolist() == [0.0, 0.0]
    assert port.current_na(5 * MS) == pytest.approx([3.0, 3.0], abs=1e-6)
    assert port.current_na(55 * MS) == pytest.approx([-1.0, -1.0], abs=1e-6)


def test_noise_has_its_mean_and_deviation_and_is_independent_between_neurons() -> None:
    port = port_of(NoisyCurrentSource(mean=0.5, stdev=0.1))
    drawn = np.array([port.current_na(t * MS) for t in range(4000)])
    error = 0.1 / np.sqrt(4000)
    assert drawn.mean(axis=0) == pytest.approx([0.5, 0.5], abs=5 * error)
    assert drawn.std(axis=0) == pytest.approx([0.1, 0.1], abs=5 * error)
    assert abs(np.corrcoef(drawn.T)[0, 1]) < 5 / np.sqrt(4000)


def test_a_restored_state_of_the_saved_currents_continues_exactly() -> None:
    port, other = port_of(NoisyCurrentSource()), port_of(NoisyCurrentSource(), seed=2)
    for t in range(5):
        port.current_na(t * MS)
    other.restore(port.save())
    assert [other.current_na(t * MS).tolist() for t in range(5, 9)] == [
        port.current_na(t * MS).tolist() for t in range(5, 9)
    ]


def test_a_silenced_current_is_zero_and_keeps_its_settings() -> None:
    port = port_of(ACSource(offset=1.0))
    port.active = False
    assert port.current_na(0).tolist() == [0.0, 0.0]
    port.active = True
    assert port.current_na(0).any()


def test_a_constant_current_changes_only_at_its_borders() -> None:
    port = port_of(DCSource(amplitude=1.0, start=2.0, stop=4.0))
    assert [port.next_change_ns(t * MS) for t in (0, 2, 4)] == [2 * MS, 4 * MS, FOREVER_NS]


def test_a_grid_of_zero_width_is_refused(golden: Golden) -> None:
    with golden.raises(ValueError):
        NoisyCurrentSource(dt=0.0)
