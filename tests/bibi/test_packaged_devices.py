"""Devices of packages, by name in BIBI documents."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

from experiment_fixtures import Install
from golden import Golden
from nrp_bibi.generation.transformation import generate
from nrp_bibi.loader import load_bibi
from nrp_bibi.reader import parse_bibi
from nrp_bibi.reverse.functions import as_function
from nrp_bibi.writer import bibi_text

from nrp_core.brain.backends import brains
from nrp_core.dsl import device
from nrp_core.dsl.device_kinds import DEVICES
from nrp_core.errors import BackendLoadError, ExperimentError, UnknownBackendError
from nrp_core.network.pynn import builder

PACKAGE = """
import hbp_nrp_client.tf_framework as nrp
from nrp_core.brain import DCSource, PopulationRate

class Envelope(nrp.CustomDevice):
    default_property = "level"

    def apply(self, neurons, brain):
        self._sink = brain.add_sink(PopulationRate(tau_fall=50.0), neurons.ids, name="envelope")

    @property
    def level(self):
        return self._sink.rate / len(self._sink.neurons)

class Current(nrp.CustomDevice):
    default_property = "amplitude"
    drives = True

    def apply(self, neurons, brain):
        self._source = brain.add_source(DCSource(), neurons.ids, name="current")

    @property
    def amplitude(self):
        return self._source.amplitude

    @amplitude.setter
    def amplitude(self, value):
        self._source.amplitude = value

class NoDevice:
    pass
"""
ENTRY_POINTS = """[nrp_core.devices]
Envelope = lab_devices:Envelope
Current = lab_devices:Current
NoDevice = lab_devices:NoDevice
"""
DOCUMENT = """<bibi xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
<transferFunction xsi:type="Robot2Neuron" name="follow">
  <device name="envelope" type="Envelope"><neurons xsi:type="Population" population="cells"/></device>
  <device name="current" type="Current">
    <body xsi:type="ArgumentReference" name="envelope" property="level"/>
    <neurons xsi:type="Index" population="cells" index="0"/>
  </device>
</transferFunction>
</bibi>"""


def test_a_document_names_them_and_its_functions_use_them(install: Install, tmp_path: Path) -> None:
    install("lab_devices", ENTRY_POINTS, PACKAGE)
    path = tmp_path / "m.bibi"
    path.write_text(DOCUMENT)
    (function,) = load_bibi(path)
    sim = builder()
    sim.setup(timestep=0.1)
    sim.Population(2, sim.IF_curr_exp(i_offset=1.0), label="cells")
    backend = brains().load("event")
    with backend.open(sim.network(), seed=0, options=backend.options()) as brain:
        function.bind(brain, None)  # type: ignore[arg-type]
        brain.run_until(200_000_000)
        function.run(200_000_000)
        ports: dict[str, Any] = {port.name: port for port in brain.devices}
        assert ports["current"].amplitude == ports["envelope"].rate / 2 > 1.0


def test_a_document_with_them_is_written_read_and_made_of_its_python_again(
    install: Install, tmp_path: Path
) -> None:
    install("lab_devices", ENTRY_POINTS, PACKAGE)
    model = parse_bibi(DOCUMENT)
    assert parse_bibi(bibi_text(model)) == model
    python = generate(model, tmp_path / "m.bibi", with_imports=False)
    assert '@nrp.MapSpikeSource("current", nrp.brain.cells[0], nrp.device("Current"))' in python
    (function,) = ast.parse(python).body
    assert isinstance(function, ast.FunctionDef)
    assert as_function(function) == model.transfer_function[0]


def test_a_name_that_no_package_has_is_refused(install: Install, golden: Golden) -> None:
    with golden.raises(ExperimentError, match="'Envelope'"):
        parse_bibi(DOCUMENT)
    with golden.raises(UnknownBackendError, match="'Envelope'"):
        device("Envelope")
    install("lab_devices", ENTRY_POINTS, PACKAGE)
    assert DEVICES.names() == ["Current", "Envelope", "NoDevice"]
    with golden.raises(BackendLoadError, match="'NoDevice' of lab_devices"):
        device("NoDevice")
