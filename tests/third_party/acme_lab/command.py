"""``nrp acme-spikes``."""

from __future__ import annotations

import typer

from nrp_core.cli.options import RecordingPath, open_recording
from nrp_core.recording import Numbers


def spikes(recording: RecordingPath) -> None:
    """Print the number of spikes of each population of a recording."""
    for name, (ids, _) in Numbers.of(open_recording(recording, "counted")).spikes.items():
        typer.echo(f"{name}: {len(ids)}")
