"""The surroundings of a scene: the Earth's magnetic field, its atmosphere, and the place on the Earth."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, degrees, hypot, radians, sin, sqrt

from nrp_core.scene.rigid import Vector

_GRAVITY, _MOLAR_MASS, _GAS = 9.80665, 0.0289644, 8.31446
"""m/s^2, kg/mol and J/(mol K): U.S. Standard Atmosphere, 1976."""
_EQUATOR_M, _FLATTENING = 6378137.0, 1 / 298.257223563
"""Semi-major axis and flattening of WGS 84."""
_ECCENTRICITY2 = _FLATTENING * (2 - _FLATTENING)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The surroundings of a world; the defaults are those of SDF.

    Args:
        magnetic_field: along the axes of the world, T.
        temperature: at height 0, K.
        temperature_gradient: its change with height, K/m.
        pressure: of the air at height 0, Pa.
        latitude, longitude: of the world's origin, degrees.
        elevation: of the origin above the ellipsoid WGS 84, m.
        heading: of the world's x axis, degrees counter-clockwise from east.
    """

    magnetic_field: Vector = (5.5645e-6, 22.8758e-6, -42.3884e-6)
    temperature: float = 288.15
    temperature_gradient: float = -0.0065
    pressure: float = 101325.0
    latitude: float = 0.0
    longitude: float = 0.0
    elevation: float = 0.0
    heading: float = 0.0

    def pressure_at(self, height: float) -> float:
        """Return the pressure (Pa) of the air at a height (m), by the barometric formula of one layer."""
        warmth = 1 + self.temperature_gradient * height / self.temperature
        return float(self.pressure * warmth ** (-_GRAVITY * _MOLAR_MASS / (_GAS * self.temperature_gradient)))

    def on_earth(self, position: Vector) -> tuple[float, float, float]:
        """Return latitude and longitude (degrees) and height above WGS 84 (m) of a position in the world."""
        x, y, up = position
        turn, lat, lon = radians(self.heading), radians(self.latitude), radians(self.longitude)
        east, north = x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn)
        # from the tangent plane at the origin to the axes of the Earth
        across = _EQUATOR_M / sqrt(1 - _ECCENTRICITY2 * sin(lat) ** 2)
        out = (across + self.elevation) * cos(lat) - sin(lat) * north + cos(lat) * up
        axial = (across * (1 - _ECCENTRICITY2) + self.elevation) * sin(lat) + cos(lat) * north + sin(lat) * up
        return _geodetic(hypot(out, east), axial, lon + atan2(east, out))


def _geodetic(out: float, axial: float, longitude: float) -> tuple[float, float, float]:
    """Return latitude, longitude (degrees) and height of a point at distances from axis and equator, m.

    Bowring's formula (1976), whose error near the ground is below 1e-9 degrees.
    """
    polar = _EQUATOR_M * (1 - _FLATTENING)
    slope = atan2(axial * _EQUATOR_M, out * polar)
    second = _ECCENTRICITY2 / (1 - _ECCENTRICITY2)
    latitude = atan2(
        axial + second * polar * sin(slope) ** 3, out - _ECCENTRICITY2 * _EQUATOR_M * cos(slope) ** 3
    )
    across = _EQUATOR_M / sqrt(1 - _ECCENTRICITY2 * sin(latitude) ** 2)
    height = out * cos(latitude) + axial * sin(latitude) - _EQUATOR_M**2 / across
    return degrees(latitude), (degrees(longitude) + 180) % 360 - 180, height
