"""A circuit in SONATA, for the tests of brains."""

from __future__ import annotations

from pathlib import Path

import pytest
from sonata_circuits import write_circuit


@pytest.fixture
def circuit(tmp_path: Path) -> Path:
    """A circuit of six nodes and three virtual ones."""
    return write_circuit(tmp_path)
