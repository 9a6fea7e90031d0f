"""What PyNN's own classes take in silence, or refuse without a word: each is one sentence here."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nrp_core.pynn as sim
from nrp_core import NrpError

Cells = Any


@pytest.fixture
def cells() -> Cells:
    sim.setup(timestep=0.1)
    return sim.Population(4, sim.IF_curr_exp(), label="cells")


def normal(**named: Any) -> Any:
    return sim.RandomDistribution("normal", **{"mu": 0.5, "sigma": 0.1, **named})


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda _: sim.IF_curr_exp(tau_m=True),
            "IF_curr_exp: tau_m is True; it must be a number",
        ),
        (
            lambda _: sim.StaticSynapse(weight=False),
            "StaticSynapse: weight is False; it must be a number",
        ),
        (
            lambda cells: cells.initialize(v=sim.RandomDistribution),
            "population 'cells': v is the class RandomDistribution; it must be a number",
        ),
        (
            lambda _: sim.SpikeSourceArray(spike_times=[10.0, [20.0]]),
            "SpikeSourceArray: spike_times is [10.0, [20.0]]; it must be a number",
        ),
        (
            lambda cells: cells[2].record("v"),
            "this is one cell of 'cells', which has no 'record'; a slice is a view of it: [2:3]",
        ),
        (
            lambda cells: sim.Projection(cells, cells[2], sim.AllToAllConnector()),
            "which has no 'label'; a slice is a view of it: [2:3]",
        ),
        (
            lambda _: sim.STDPMechanism(sim.SpikePairRule(), sim.AdditiveWeightDependence),
            "its weight_dependence is AdditiveWeightDependence; it must be one such as",
        ),
        (lambda _: sim.run(float("nan")), "run: the time must be finite, not nan ms"),
        (lambda _: sim.run(float("inf"), callbacks=[lambda t: t + 1.0]), "must be finite, not inf ms"),
        (lambda _: sim.NumpyRNG(seed="7"), "NumpyRNG: its seed is '7'; it must be a whole number, or None"),
        (lambda _: normal(rng=7), "the distribution 'normal': its rng is 7; it must be a generator such as"),
        (lambda _: normal(sigma="0.1"), "the distribution 'normal': sigma is '0.1', not a number"),
        (lambda _: normal(mu=None), "the distribution 'normal': mu is None, not a number"),
        (
            lambda _: sim.setup(timestep=0.1, options="threads=2"),
            "its options is 'threads=2'; it must be a dictionary",
        ),
        (lambda _: sim.setup(timestep=0.1, seed="7"), "a seed is an integer, not '7'"),
        (
            lambda _: sim.setup(timestep=0.1, backend="evnt"),
            "no brain backend is called 'evnt'; did you mean 'event'?",
        ),
        (
            lambda _: sim.run(1.0, callbacks=[3.0]),
            "callbacks are a list of functions, which are called with the time",
        ),
        (lambda _: sim.run(1.0, callbacks=print), "callbacks are a list of functions"),
        (lambda _: sim.run_until("10"), "run: the time is a number of ms, not '10'"),
        (lambda _: sim.run(True), "run: the time is a number of ms, not True"),
        (lambda _: sim.get_simulator("nest"), "(name, help) of further ones of the command line, not 'nest'"),
        (
            lambda cells: cells.nearest((0, 0)),
            "population 'cells': nearest takes three numbers, um, not (0, 0)",
        ),
        (lambda _: sim.setup(timestep=0.1, max_delay=float("nan")), "max_delay (nan ms) must be at least"),
        (lambda cells: sim.Assembly(cells, label=3), "Assembly: its label is 3; it must be a text"),
        (lambda cells: sim.Assembly(cells, 3), "its part is 3; it must be a population or a view"),
        (
            lambda cells: cells.record("v", sampling_interval="1 ms"),
            "sampling_interval is '1 ms' ms; it must be",
        ),
        (
            lambda cells: cells.write_data("out.xyz"),
            "population 'cells': data are not written to 'out.xyz'; valid: ",
        ),
        (lambda cells: cells.set(tau_m={"a": 20}), "tau_m is {'a': 20}; it must be a number"),
        (
            lambda _: sim.Population(2, sim.IF_curr_exp(), label="a", initial_values=[-60.0]),
            "population 'a': its initial_values is [-60.0]; it must be a dictionary",
        ),
    ],
)
def test_an_impossible_argument_is_named(call: Callable[[Cells], object], words: str, cells: Cells) -> None:
    with pytest.raises(NrpError, match=re.escape(words)):
        call(cells)


def test_possible_arguments_are_accepted(cells: Cells, tmp_path: Path) -> None:
    cells.set(i_offset=normal(rng=sim.NumpyRNG(seed=1)), tau_m=sim.RandomDistribution("uniform", (10, 20)))
    assert cells.nearest(np.array([2.2, 0.0, 0.0])) == cells[2]
    cells.record("v", sampling_interval=np.float64(0.5))
    sim.run(np.int64(1), callbacks=(lambda t: t + 0.5,))
    sim.run(1, callbacks=[])
    cells.write_data(str(tmp_path / "out.pkl"), clear=True)
    assert (tmp_path / "out.pkl").exists()
    sim.setup(timestep=0.1, seed=np.int64(7), options=None)


@pytest.mark.parametrize(
    ("structure", "told"), [(lambda: sim.Line(dx=0), True), (lambda: sim.Grid3D(dx=0, dy=1.0), False)]
)
def test_cells_at_one_place_are_reported(structure: Callable[[], Any], told: bool, cells: Cells) -> None:
    sim.Population(8, sim.IF_curr_exp(), structure=structure(), label="line")
    sim.Population(1, sim.IF_curr_exp(), structure=structure(), label="single")
    remarks = [one for one in sim.network().remarks if "at one place" in one]
    words = "all cells of 'line' are at one place, because the steps of its structure are 0 um"
    assert remarks == ([words] if told else [])
