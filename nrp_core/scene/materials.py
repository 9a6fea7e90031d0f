"""Gazebo's named materials and plain colour names as colours.

The values are those of Gazebo's own ``gazebo.material`` (github.com/gazebosim/gazebo-classic): the diffuse
colour, for a glowing material the emissive one. Materials with a texture have a colour near its mean.
"""

from __future__ import annotations

from types import MappingProxyType

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.scene.model import Rgba

_OPAQUE: dict[str, tuple[float, float, float]] = {
    "Grey": (0.7, 0.7, 0.7),
    "DarkGrey": (0.175, 0.175, 0.175),
    "White": (1, 1, 1),
    "FlatBlack": (0.1, 0.1, 0.1),
    "Black": (0, 0, 0),
    "Red": (1, 0, 0),
    "RedBright": (0.87, 0.26, 0.07),
    "Green": (0, 1, 0),
    "Blue": (0, 0, 1),
    "SkyBlue": (0.13, 0.44, 0.70),
    "Yellow": (1, 1, 0),
    "ZincYellow": (0.9725, 0.9529, 0.2078),
    "DarkYellow": (0.7, 0.7, 0),
    "Purple": (1, 0, 1),
    "Turquoise": (0, 1, 1),
    "Orange": (1, 0.5088, 0.0468),
    "Indigo": (0.33, 0, 0.5),
    "Gold": (0.8, 0.64869, 0.120759),
    "LightOn": (0, 1, 0),
    "LightOff": (1, 0, 0),
    "Pioneer2Body": (0.681193, 0.000923, 0.000923),
    "PioneerBody": (1, 0, 0),
    "JointAnchor": (1, 1, 1),
    # textures
    "Wood": (0.55, 0.40, 0.25),
    "WoodFloor": (0.60, 0.45, 0.28),
    "WoodPallet": (0.60, 0.48, 0.32),
    "Bricks": (0.50, 0.35, 0.30),
    "CeilingTiled": (0.85, 0.85, 0.85),
    "PaintedWall": (0.85, 0.83, 0.78),
    "WindowFrame": (0.80, 0.80, 0.80),
    "Grass": (0.30, 0.42, 0.16),
    "CloudySky": (0.60, 0.70, 0.85),
    "GreyGradientSky": (0.60, 0.60, 0.60),
    "Steps": (0.60, 0.60, 0.58),
}
_ROADS = (
    *("Road", "Residential", "Tertiary", "Motorway", "Trunk", "Primary", "Secondary"),
    *("Lane_1", "Lanes_2", "Lanes_4", "Lanes_6"),
)
_PAVEMENTS = ("Pedestrian", "Footway")

_GLOWING = ("White", "Red", "Green", "Blue", "Yellow", "Purple", "Turquoise")
_TRANSPARENT: dict[str, Rgba] = {
    "Red": (1, 0, 0, 0.5),
    "Green": (0, 1, 0, 0.5),
    "Blue": (0, 0, 1, 0.5),
    "Grey": (0.5, 0.5, 0.5, 0.5),
    "Black": (0, 0, 0, 0.5),
    "Yellow": (1, 1, 0, 0.5),
    "Orange": (1, 0.44, 0, 0.4),
    "DarkOrange": (1, 0.33, 0, 0.5),
    "DarkMagenta": (0.55, 0, 0.55, 0.5),
}


def _table() -> dict[str, Rgba]:
    table: dict[str, Rgba] = {
        name: (float(r), float(g), float(b), 1.0) for name, (r, g, b) in _OPAQUE.items()
    }
    table |= dict.fromkeys(_ROADS, (0.30, 0.30, 0.30, 1.0))
    table |= dict.fromkeys(_PAVEMENTS, (0.55, 0.55, 0.53, 1.0))
    table |= {f"{name}Glow": table[name] for name in _GLOWING}
    table["TurquoiseGlowOutline"] = table["TurquoiseGlow"]
    table["BlueLaser"] = (0.0, 0.0, 1.0, 0.4)
    for name, (r, g, b, alpha) in _TRANSPARENT.items():
        table[f"{name}Transparent"] = table[f"{name}TransparentOverlay"] = float(r), float(g), float(b), alpha
    return {f"Gazebo/{name}": rgba for name, rgba in table.items()}


MATERIALS = MappingProxyType(_table())
"""Colour of each material by its full name, ``Gazebo/RedGlow``."""

_BY_SHORT_NAME = {name.removeprefix("Gazebo/").lower(): rgba for name, rgba in MATERIALS.items()}
_BY_SHORT_NAME |= {name.replace("grey", "gray"): rgba for name, rgba in _BY_SHORT_NAME.items()}
_BY_SHORT_NAME["torquoise"] = _BY_SHORT_NAME["turquoise"]  # as early versions of Gazebo spelled it


def glows(name: str) -> bool:
    """Return whether a material of Gazebo has its colour in any light."""
    return "glow" in name.lower()


def color_of(name: str) -> Rgba:
    """Return the colour of a material or a colour name.

    Args:
        name: ``Gazebo/RedGlow``, ``RedGlow`` or ``red``; upper and lower case are the same.

    Raises:
        SceneError: Gazebo does not have it.
    """
    short = name.strip().lower().removeprefix("gazebo/")
    if short not in _BY_SHORT_NAME:
        raise SceneError(f"there is no material '{name}'{did_you_mean(short, _BY_SHORT_NAME)}")
    return _BY_SHORT_NAME[short]
