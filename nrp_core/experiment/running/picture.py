"""A picture of a run's present state: the scene from outside, and the rates of the populations."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.files import replace_file
from nrp_core.errors import CapabilityError, ExperimentError
from nrp_core.paths import check_free, path_of
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.posture import body_poses
from nrp_core.scene.rigid import BodyPath, matrix_of
from nrp_core.world.world import World


@dataclass(frozen=True, slots=True, repr=False)
class Picture:
    """A picture that notebooks show.

    Args:
        pixels: the scene, RGB, shape ``(height, width, 3)``.
        title: the experiment and the time.
        rates_hz: the mean rate of each population and view since the start, by its name.
    """

    pixels: npt.NDArray[np.uint8]
    title: str
    rates_hz: Mapping[str, float]

    @checks_arguments()
    def save(self, path: Path | str, *, overwrite: bool = False) -> None:
        """Write the scene as a .png file.

        Args:
            path: the file.
            overwrite: whether to replace an existing file.

        Raises:
            ExperimentError: the suffix is another one, or the file exists or cannot be written.
        """
        target = path_of(path)
        if target.suffix.lower() != ".png":
            raise ExperimentError(f"a picture is a .png file, not '{target.name}'")
        check_free(target, overwrite=overwrite)
        replace_file(target, self._repr_png_())

    def __repr__(self) -> str:
        height, width, _ = self.pixels.shape
        return f"<Picture of {self.title}, {width} x {height} pixels>"

    def _repr_png_(self) -> bytes:
        import cv2

        return cv2.imencode(".png", self.pixels[:, :, ::-1])[1].tobytes()

    def _repr_html_(self) -> str:
        data = b64encode(self._repr_png_()).decode()
        rates = ", ".join(f"{escape(name)} {rate:.3g} Hz" for name, rate in self.rates_hz.items())
        title = escape(self.title)
        image = f'<img src="data:image/png;base64,{data}" alt="{title}" width="{self.pixels.shape[1]}">'
        return f"<figure>{image}<figcaption>{title}<br>mean rates: {rates}</figcaption></figure>"


def image_of(world: World, width: int, height: int, of: Collection[str]) -> npt.NDArray[np.uint8]:
    """Return an image of a world's present state; see :func:`.portrait`.

    Raises:
        SceneError: the scene cannot be drawn, or the model does not exist.
    """
    from nrp_core.world.drives.muscles import drawn_muscles, drawn_paths  # most runs show no picture
    from nrp_core.world.render.portrait import Moment, portrait
    from nrp_core.world.render.tubes import activation_rgba

    scene, engine = world.scene, world.engine
    for name in of:
        scene.model(name)
    try:
        muscles = [
            (np.array(points), muscle.radius, activation_rgba(activation))
            for muscle, points, activation in drawn_paths(engine, drawn_muscles(scene))
        ]
        moment = Moment(lambda paths, rows: engine.frames(paths)(rows), muscles, engine.visual_colors)
        return portrait(scene, width, height, moment=moment, of=of)
    except CapabilityError:  # the engine reports only models
        moment = Moment(lambda paths, rows: _with_models(world, paths, rows), (), engine.visual_colors)
        return portrait(scene, width, height, moment=moment, of=of)


def _with_models(world: World, paths: Sequence[BodyPath], rows: FloatArray) -> None:
    """Write the frames of bodies that move with their models."""
    models = {name: world.scene.model(name) for name, _ in paths}
    starts = {name: body_poses(model, bodies_of(model)) for name, model in models.items()}
    for row, (name, index) in zip(rows, paths, strict=True):
        now = world.model_motion(name).pose
        row[:] = matrix_of(now @ models[name].pose.inverse() @ starts[name][index])
