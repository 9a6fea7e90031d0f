"""A SONATA circuit of which one file is changed at random is usable, or refused in clear words."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from mutations import Tally, mutated, numbered
from nrp_brain_event import EventBackend
from nrp_formats.sonata import read_sonata
from sonata_circuits import write_circuit

from nrp_core.errors import ExperimentError, NetworkError, NrpError

FILES = (
    "circuit_config.json",
    "circuit_config.json",
    "all_types.csv",
    "edge_types.csv",
    "models/exc.json",
    "nodes.h5",
    "edges.h5",
)
LARGEST = 1_000
"""Neurons; the sound circuit has nine."""


@pytest.fixture
def sound(tmp_path: Path) -> Path:
    """A circuit of six cells and three virtual ones."""
    folder = tmp_path / "sound"
    folder.mkdir()
    write_circuit(folder)
    return folder


def use(config: Path) -> None:
    """Read it and let it fire for 2 ms; what comes out are spikes of its neurons, and numbers."""
    network = read_sonata(config)
    assert network.size < LARGEST, network.size
    for projection in network.projections:
        assert np.isfinite(projection.weight).all()
        assert (np.isfinite(projection.delay_ms) & (projection.delay_ms >= 0)).all()
    if not network.size:
        return
    backend = EventBackend()
    with backend.open(network, seed=1, options=backend.options()) as brain:
        brain.run_until(2_000_000)
        for label, population in network.populations.items():
            if not population.is_source:
                assert np.isfinite(brain.read_state("v", network.ids_of(label))).all()


def test_a_mutated_circuit_is_usable_or_refused_in_clear_words(sound: Path, tmp_path: Path) -> None:
    folder = tmp_path / "mutated"
    use(sound / "circuit_config.json")

    def is_clear(error: NrpError) -> bool:
        names_file = error.path is not None if isinstance(error, ExperimentError) else bool(str(error))
        return names_file and "Traceback" not in str(error)

    tally = Tally("SONATA circuit", is_clear)
    for number, random in numbered("SONATA circuit"):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(sound, folder)
        file = folder / random.choice(FILES)
        file.write_bytes(mutated(file.read_bytes(), random, text=file.suffix != ".h5"))
        tally.take(number, lambda: use(folder / "circuit_config.json"))
    tally.check()


def test_a_heap_in_which_the_library_would_search_for_ever_is_refused(sound: Path, golden: Golden) -> None:
    path = sound / "edges.h5"
    data = bytearray(path.read_bytes())
    heap = data.index(b"GCOL")
    free = data.index((4032).to_bytes(8, "little"), heap)  # what its two texts leave of its 4096 bytes
    data[free : free + 8] = bytes(8)
    path.write_bytes(data)
    with golden.raises(NetworkError, match=r"edges\.h5"):
        read_sonata(sound / "circuit_config.json")
