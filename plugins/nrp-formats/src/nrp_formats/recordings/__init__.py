"""Recordings in the files of other programs: NWB and SONATA, for ``nrp export``."""

from __future__ import annotations

import os
from pathlib import Path

from nrp_core.recording import Exporter, Recording
from nrp_core.utilities import require_extra


def _write_nwb(recording: Recording, path: Path) -> list[Path]:
    require_extra("pynwb", "nrp-formats[nwb]", "an export to NWB")
    # a cache cut short by a full disk breaks later imports
    os.environ.setdefault("PYNWB_NO_CACHE_DIR", "1")
    from nrp_formats.recordings.nwb import write_nwb

    return write_nwb(recording, path)


def _write_sonata(recording: Recording, folder: Path) -> list[Path]:
    from nrp_formats.recordings.sonata import write_sonata

    return write_sonata(recording, folder)


NWB = Exporter(_write_nwb, ".nwb")
"""Neurodata Without Borders, one file: spikes, devices, poses, commands and images."""
SONATA = Exporter(_write_sonata)
"""A folder with the spikes, the devices as a report, and the named groups of neurons."""
