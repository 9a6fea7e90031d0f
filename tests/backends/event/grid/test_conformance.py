"""The grid mode passes the conformance kit, as any backend's brain would."""

from nrp_conformance import BrainBackendTests
from nrp_conformance.brain.state import SequenceTests


class TestOnAFineGrid(BrainBackendTests):
    backend_name = "event"
    options = {"resolution": "0.1 ms"}  # noqa: RUF012


class TestSequencesOnACoarseGrid(SequenceTests):
    backend_name = "event"
    options = {"resolution": "1 ms"}  # noqa: RUF012


class TestSequencesByThreeThreads(SequenceTests):
    backend_name = "event"
    options = {"resolution": "0.1 ms", "threads": 3}  # noqa: RUF012
