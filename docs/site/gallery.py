"""The gallery: every experiment that ships is run, and its figure shown."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import entry_points
from importlib.resources import files
from pathlib import Path, PurePosixPath

from pages import write_page
from paths import PAGES
from ruamel.yaml import YAML

FIGURES = PAGES / "images" / "gallery"
INTRODUCTION = """\
# Gallery

Each figure is drawn by `nrp run NAME --plot FILE` from one run of an experiment that ships, when this site is
built. The marks at the top right are the criteria of the experiment.
"""

COCKPIT = {
    "cockpit": "A run of the Husky in the cockpit",
    "cockpit-fly": "A fly of true size at a film of sugar",
    "cockpit-functions": "A transfer function and what its calls take",
    "cockpit-compare": "Two futures of a run beside each other",
    "cockpit-sweep": "A sweep of settings and seeds",
    "designer": "Transfer functions as boxes and wires",
    "designer-brain": "A brain as boxes and wires",
}
"""The pictures of the cockpit, which a script of its plugin takes."""

LIVE = "braitenberg_husky"
"""The experiment whose run the site offers to play with, as one file that `nrp share` wrote."""
VIDEOS = {"fly": ("--speed", "0.25")}
"""The experiments of which a video is made, and the options of `nrp video`."""


def figures() -> list[Callable[[], None]]:
    """Return what draws the figures, to be called in any order or at once."""
    FIGURES.mkdir(parents=True, exist_ok=True)
    return [lambda name=name: _draw(name) for name in _shipped()]  # type: ignore[misc]


def write_gallery() -> None:
    """Write the page, once the figures are drawn."""
    entries = []
    for name, package in _shipped().items():
        experiment = YAML(typ="safe").load((files(package) / "experiment.yaml").read_text())
        text = f"## {name.replace('_', ' ').capitalize()}\n\n{experiment['description'].strip()}\n"
        text += f"\n[![The run of {name}](images/gallery/{name}.png)](images/gallery/{name}.png)\n"
        if name == LIVE:
            text += "\n[Play with this run](images/gallery/live.html): one file, which needs no server.\n"
        if name in VIDEOS:
            film = f'<video controls muted width="640" src="images/gallery/{name}.mp4"></video>'
            text += f"\n{film}\n\n`nrp video` made it of the recorded run.\n"
        entries.append(f"{text}\n```sh\nnrp run {name} --plot {name}.png\n```\n")
    shown = [f"![{words}](images/{name}.png)\n" for name, words in COCKPIT.items()]
    write_page(PurePosixPath("gallery.md"), "\n".join([INTRODUCTION, *entries, "## The cockpit\n", *shown]))


def _shipped() -> dict[str, str]:
    """Return the package of each experiment."""
    entries = entry_points(group="nrp_core.experiments")
    return {entry.name: entry.value for entry in sorted(entries, key=lambda entry: entry.name)}


def _draw(name: str) -> None:
    figure = ["run", name, "--overwrite", "--plot", str(FIGURES / f"{name}.png")]
    if name not in (LIVE, *VIDEOS):
        _nrp(*figure)
        return
    with tempfile.TemporaryDirectory() as folder:
        recording = str(Path(folder, name))
        _nrp(*figure, "--record", recording)
        if name in VIDEOS:
            _nrp("video", recording, *VIDEOS[name], "--overwrite", "-o", str(FIGURES / f"{name}.mp4"))
        if name == LIVE:
            _nrp("share", recording, "--overwrite", "-o", str(FIGURES / "live.html"))


def _nrp(*words: str) -> None:
    command = [str(Path(sys.executable).parent / "nrp"), *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")
