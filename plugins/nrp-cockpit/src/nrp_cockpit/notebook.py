"""A recording in a notebook, in the page of the cockpit."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from nrp_cockpit.sharing.sharing import MOST_BYTES, shared_file
from nrp_core.errors import ExperimentError
from nrp_core.recording import Recording
from nrp_core.utilities import checks_arguments

_LEAST_PX, _LEAST_MB = 200, 2.0


@dataclass(frozen=True, slots=True)
class PlayedRecording:
    """The page that plays a recording, which JupyterLab and VS Code show in a frame; it needs no server.

    Args:
        page: the page, as ``nrp share`` writes it.
        height_px: the height of the frame, pixels.
        losses: the data omitted to limit its size; a sentence for each topic.
    """

    page: str = field(repr=False)
    height_px: int
    losses: tuple[str, ...] = ()

    def _repr_html_(self) -> str:
        # the page may run its script and save files, and reaches nothing of the notebook that it is in
        style = f"width: 100%; height: {self.height_px}px; border: 0"
        sandbox = "allow-scripts allow-downloads"
        return f'<iframe sandbox="{sandbox}" style="{style}" srcdoc="{escape(self.page)}"></iframe>'


@checks_arguments()
def show(
    recording: Recording | Path | str, *, height_px: int = 720, max_size_mb: float = MOST_BYTES / 1e6
) -> PlayedRecording:
    """Show a recording in a notebook, with its scene, spikes, images and timeline.

    The page becomes part of the notebook, which is larger by its size.

    Args:
        recording: a recording, or its folder.
        height_px: the height of the frame, pixels.
        max_size_mb: the maximum size of the page, MB; topics are thinned until it fits, the largest first.

    Raises:
        ExperimentError: the recording does not exist, or it does not fit.
    """
    if height_px < _LEAST_PX or max_size_mb < _LEAST_MB:
        raise ExperimentError(f"the frame needs {_LEAST_PX} pixels, and the page {_LEAST_MB:g} MB at least")
    folder = (recording if isinstance(recording, Recording) else Recording(recording)).folder
    shared = shared_file(folder, round(max_size_mb * 1e6))
    return PlayedRecording(shared.html, height_px, shared.losses)
