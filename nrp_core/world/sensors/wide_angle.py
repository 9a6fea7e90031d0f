"""Wide-angle cameras: images of a fisheye lens, made from up to six cameras that look to all sides."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import pi, sin, tan
from typing import ClassVar, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.errors import did_you_mean
from nrp_core.messages.sensor_msgs import CameraInfo
from nrp_core.messages.std_msgs import Header
from nrp_core.scene.devices import View
from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.sensors import Mount, field_of_view
from nrp_core.scene.rigid import Pose, rotation_matrix
from nrp_core.world.engine import Engine
from nrp_core.world.render.cameras import ImageArray
from nrp_core.world.sensors.camera import Camera, CameraPart, ImageSensor

_FUNCTIONS: Final[Mapping[str, Callable[[float], float]]] = {"sin": sin, "tan": tan, "id": float}
_INVERSES: Final[Mapping[str, Callable[[FloatArray], FloatArray]]] = {
    "sin": lambda share: np.arcsin(np.where(np.abs(share) <= 1, share, np.nan)),
    "tan": np.arctan,
    "id": np.asarray,
}
_KNOWN: Final[Mapping[str, tuple[float, float, str]]] = {
    "gnomonical": (1.0, 1.0, "tan"),
    "stereographic": (2.0, 2.0, "tan"),
    "equidistant": (1.0, 1.0, "id"),
    "equisolid_angle": (2.0, 2.0, "sin"),
    "orthographic": (1.0, 1.0, "sin"),
}
"""Scale, divisor of the angle and function of the lenses that SDF names."""
_CUSTOM: Final = "custom"


@dataclass(frozen=True, slots=True)
class Lens:
    """A lens of SDF: ``r = c1 * f * fun(theta / c2 + c3)`` in half widths of the image, ``theta`` in rad.

    Args:
        cutoff: the angle (rad) to the line of sight beyond which the image is black.
    """

    c1: float = 2.0
    c2: float = 2.0
    c3: float = 0.0
    f: float = 1.0
    fun: str = "tan"
    cutoff: float = pi / 2

    @classmethod
    def read(cls, lens: Element, fov: float) -> Lens:
        """Read a ``<lens>``.

        Args:
            lens: the element, which may be empty.
            fov: the horizontal field of view, rad, to which the image is scaled if the file asks for it.

        Raises:
            SceneError: its type or function is unknown, or a number is impossible.
        """
        kind = lens.word("type", "stereographic")
        if kind not in (*_KNOWN, _CUSTOM):
            hint = did_you_mean(kind, [*_KNOWN, _CUSTOM])
            raise lens.require("type").error(f"unknown type '{kind}' of a <lens>{hint}")
        given = lens.section("custom_function")
        if kind == _CUSTOM:
            c1, c2, fun = given.positive("c1", 1.0), given.positive("c2", 1.0), given.word("fun", "tan")
            c3, f = given.number("c3", 0.0), given.positive("f", 1.0)
            if fun not in _FUNCTIONS:
                raise given.require("fun").error(f"unknown <fun> '{fun}'{did_you_mean(fun, _FUNCTIONS)}")
        else:
            (c1, c2, fun), c3, f = _KNOWN[kind], 0.0, 1.0
        if lens.flag("scale_to_hfov", True):
            edge = c1 * _FUNCTIONS[fun](fov / 2 / c2 + c3)
            if edge <= 0:
                raise lens.error(f"a <lens> of type '{kind}' cannot show a <horizontal_fov> of {fov:g}")
            f = 1 / edge
        return cls(c1, c2, c3, f, fun, lens.positive("cutoff_angle", pi / 2))

    def radius(self, theta: float) -> float:
        """Return where a ray at an angle to the line of sight arrives, in half widths."""
        return self.c1 * self.f * _FUNCTIONS[self.fun](theta / self.c2 + self.c3)

    def angles(self, radii: FloatArray) -> FloatArray:
        """Return the angles (rad) of the rays that arrive at some distances from the centre.

        It is NaN where none arrives: outside the lens, or beyond the angle at which it cuts off.
        """
        thetas = self.c2 * (_INVERSES[self.fun](radii / (self.c1 * self.f)) - self.c3)
        return np.where((thetas >= 0) & (thetas <= min(self.cutoff, pi)), thetas, np.nan)


_SIDES: Mapping[str, Pose] = {
    "front": Pose(),
    "left": Pose.from_rpy((0.0, 0.0, 0.0), 0.0, 0.0, pi / 2),
    "right": Pose.from_rpy((0.0, 0.0, 0.0), 0.0, 0.0, -pi / 2),
    "up": Pose.from_rpy((0.0, 0.0, 0.0), 0.0, -pi / 2, 0.0),
    "down": Pose.from_rpy((0.0, 0.0, 0.0), 0.0, pi / 2, 0.0),
    "back": Pose.from_rpy((0.0, 0.0, 0.0), 0.0, 0.0, pi),
}
"""How the sides of a cube around the camera are turned; each is seen under 90 degrees."""
_LARGEST_SIDE = 2048
_COEFFICIENTS = 4  # of the equidistant model of ROS


@dataclass(frozen=True, slots=True)
class WideAngleCamera(ImageSensor):
    """A camera with a fisheye lens; pixels outside the lens are black.

    Args:
        optics: its images, whose field of view may be up to 2 pi.
        lens: its lens.
        info_topic: absolute topic of its optics, None for none.
        side: width and height of the images of which its own are made, pixels.
    """

    tag: ClassVar[str] = "wide_angle"

    lens: Lens
    info_topic: str | None
    side: int = 256

    @property
    def view(self) -> None:
        """None: its images are made of several :attr:`views`."""
        return None

    @property
    def views(self) -> Mapping[str, View]:
        near, far, place, mask = self.optics.near, self.optics.far, self.optics.pose, self.optics.mask
        return {
            f"{self.name}/{name}": View(place @ turn, pi / 2, self.side, self.side, near, far, mask)
            for name, turn in _SIDES.items()
        }

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> WideAngleCamera:
        camera = sensor.require("camera")
        lens = camera.section("lens")
        fov = field_of_view(camera, 1.047, most=2 * pi)
        optics = Camera.read(sensor, mount, reading, fov)
        side = max(int(lens.positive("env_texture_size", 256)), optics.width)
        return cls(
            optics.name,
            optics.topic,
            optics.rate_hz,
            optics,
            Lens.read(lens, fov),
            optics.info_topic,
            min(side, _LARGEST_SIDE),
            noise=optics.noise,
        )

    def part(self, model: Model, link: str, engine: Engine) -> WideAnglePart:
        return WideAnglePart(self, model.name, link, engine)


class _Side(NamedTuple):
    """The pixels of an image that one side of the cube shows, and where in the side's image they are."""

    name: str
    rows: npt.NDArray[np.intp]
    columns: npt.NDArray[np.intp]
    pixels: npt.NDArray[np.bool_]


class WideAnglePart(CameraPart):
    """Publishes the images of one wide-angle camera."""

    def __init__(self, sensor: WideAngleCamera, model: str, link: str, engine: Engine) -> None:
        faults = {name: getattr(sensor, name) for name in ("noise", "delay", "drop_out", "frame_name")}
        super().__init__(replace(sensor.optics, **faults), model, link, engine)
        self._sensor = sensor
        self._shown: list[_Side] | None = None
        self._render = self._render_sides

    def _size(self) -> tuple[int, int]:
        scale, optics = self._engine.image_scale, self._sensor.optics
        return max(1, round(optics.height * scale)), max(1, round(optics.width * scale))

    def _look(self) -> None:
        return None

    def _render_sides(self) -> ImageArray:
        """Return the image, put together from those of flat cameras."""
        if self._shown is None:
            side, _ = self._engine.image_size(*self._place, f"{self._sensor.name}/front")
            self._shown = list(_sides(self._sensor, self._size(), side))
        image = np.zeros((*self._size(), 3), np.uint8)
        for shown in self._shown:
            seen = self._engine.render(*self._place, f"{self._sensor.name}/{shown.name}")
            image[shown.pixels] = seen[shown.rows, shown.columns]
        image.flags.writeable = False
        return image

    def _optics(self, header: Header) -> CameraInfo:
        """Return its optics in the equidistant model of ROS, fitted to the lens as far as it shows."""
        height, width = self._size()
        lens = self._sensor.lens
        shown = lens.angles(np.linspace(0.0, np.hypot(1.0, height / width), 400))
        thetas = shown[np.isfinite(shown) & (shown > 0)]
        radii = np.array([lens.radius(theta) for theta in thetas.tolist()])
        powers = thetas[:, None] ** (2 * np.arange(_COEFFICIENTS + 1) + 1)
        fit, *_ = np.linalg.lstsq(powers, radii, rcond=None)
        focal = float(fit[0]) * width / 2
        k = np.array([[focal, 0.0, width / 2], [0.0, focal, height / 2], [0.0, 0.0, 1.0]])
        p = np.column_stack([k, np.zeros(3)])
        return CameraInfo(
            header, height, width, "equidistant", fit[1:] / fit[0], k.ravel(), np.eye(3).ravel(), p.ravel()
        )


def _sides(sensor: WideAngleCamera, size: tuple[int, int], side: int) -> Iterator[_Side]:
    """Yield the sides of the cube that its image shows."""
    rays = rays_of(sensor.lens, size)
    turns = {name: rotation_matrix(turn.orientation) for name, turn in _SIDES.items()}
    ahead = np.stack(
        [product(rays, turn[:, 0]) for turn in turns.values()]
    )  # how far each ray goes to each side
    nearest = np.where(np.isfinite(ahead).all(axis=0), np.argmax(np.nan_to_num(ahead), axis=0), -1)
    for number, (name, turn) in enumerate(turns.items()):
        pixels = nearest == number
        if not pixels.any():
            continue
        x, y, z = product(rays[pixels], turn).T
        columns = np.floor((1 - y / x) * side / 2).clip(0, side - 1).astype(np.intp)
        rows = np.floor((1 - z / x) * side / 2).clip(0, side - 1).astype(np.intp)
        yield _Side(name, rows, columns, pixels)


def rays_of(lens: Lens, size: tuple[int, int]) -> FloatArray:
    """Return the direction of the ray at each pixel, x ahead, y left, z up; NaN where the lens shows none.

    Args:
        lens: the lens.
        size: height and width of the image.

    Returns:
        Unit vectors, shape ``(height, width, 3)``.
    """
    height, width = size
    right = ((np.arange(width) + 0.5) * 2 / width - 1)[None, :]
    down = (((np.arange(height) + 0.5) * 2 - height) / width)[:, None]
    radii = np.hypot(right, down)
    thetas = lens.angles(radii)
    share = np.divide(np.sin(thetas), radii, out=np.zeros_like(radii), where=radii > 0)
    return np.stack([np.cos(thetas), -right * share, -down * share], axis=-1)
