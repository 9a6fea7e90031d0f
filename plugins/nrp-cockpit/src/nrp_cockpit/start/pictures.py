"""Pictures of experiments: their own, or their scenes, each drawn once in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from base64 import b64encode
from collections.abc import Iterable
from contextlib import suppress
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from nrp_core.errors import ExperimentError, NrpError
from nrp_core.experiment import Experiment, load_experiment, scene_of
from nrp_core.utilities import cached_folder

_TYPES: Final = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp"}
_LARGEST: Final = 1_000_000
"""Larger files are not sent to the page, bytes."""
_WIDTH, _HEIGHT = 480, 270
_NAME: Final = "scene.jpg"
_LONGEST_S: Final = 120.0


def own_picture(experiment: Experiment) -> Path | None:
    """Return the picture beside an experiment: of the name of its file, ``thumbnail``, or the only one."""
    file = experiment.source.place.path
    if file is None or not file.parent.is_dir():
        return None
    found = [path for path in sorted(file.parent.iterdir()) if path.suffix.lower() in _TYPES]
    found = [path for path in found if path.stat().st_size <= _LARGEST]
    named = [path for stem in (file.stem, "thumbnail") for path in found if path.stem == stem]
    best = named or (found if len(found) == 1 else [])
    return best[0] if best else None


def picture_key(experiment: Experiment) -> str:
    """Return a digest of all that a picture shows, equal for experiments that look the same; empty: none."""
    own = own_picture(experiment)
    if own is not None:
        return _digest("own", [own])
    room = experiment.world.scene
    if room is None:
        return ""
    robots = experiment.world.robots
    about = "".join(f"{name}={robot!r}" for name, robot in robots.items())
    return _digest(f"around robots {version('nrp-core')} {about}", [room, *_files(robots.values())])


def _files(sections: Iterable[Any]) -> list[Path]:
    return [value for one in sections for _, value in one if isinstance(value, Path)]


def _digest(text: str, files: Iterable[Path]) -> str:
    stats = [(str(path), path.stat().st_mtime_ns, path.stat().st_size) for path in files]
    return sha256(repr((text, stats)).encode()).hexdigest()[:32]


class Pictures:
    """Gives the pictures of experiments; scenes are drawn one at a time, at low priority."""

    def __init__(self) -> None:
        self._one = threading.Lock()
        self._drawing: subprocess.Popen[bytes] | None = None
        self._is_closed = False

    def data(self, name: str, key: str) -> dict[str, Any]:
        """Return a picture with its media ``type``; any thread may call this, and waits for a drawing.

        Args:
            name: the experiment, as a user writes it.
            key: of :func:`picture_key`.

        Raises:
            ExperimentError: it cannot be drawn.
        """
        own = own_picture(load_experiment(name))
        path = (
            own or cached_folder("pictures", key, lambda folder: self._draw(name, folder), _is_drawn) / _NAME
        )
        return {"type": _TYPES[path.suffix.lower()], "data": b64encode(path.read_bytes()).decode()}

    def close(self) -> None:
        """End a drawing, and begin no other."""
        self._is_closed = True
        if self._drawing is not None:
            self._drawing.kill()

    def _draw(self, name: str, folder: Path) -> None:
        with self._one:
            if self._is_closed:
                raise ExperimentError("the page is being closed")
            words = [sys.executable, "-P", "-m", __name__, name, str(folder / _NAME)]
            self._drawing = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                self._drawing.wait(_LONGEST_S)
            except subprocess.TimeoutExpired:
                self._drawing.kill()
                self._drawing.wait()
        if not _is_drawn(folder):
            raise ExperimentError(f"the scene of '{name}' cannot be drawn")


def _is_drawn(folder: Path) -> bool:
    return (folder / _NAME).is_file()


def draw(name: str, target: Path) -> None:
    """Draw the scene of an experiment without its engines.

    Raises:
        SceneError: it cannot be drawn.
    """
    import cv2

    from nrp_core.world.render.portrait import portrait

    experiment = load_experiment(name)
    of = tuple(experiment.world.robots)  # no wall is before them
    pixels = portrait(scene_of(experiment), _WIDTH, _HEIGHT, of=of)
    cv2.imwrite(str(target), pixels[:, :, ::-1])


if __name__ == "__main__":
    if hasattr(os, "nice"):
        os.nice(10)
    with suppress(NrpError):
        draw(sys.argv[1], Path(sys.argv[2]))
