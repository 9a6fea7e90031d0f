"""NumPy and SciPy with their old names."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np

from nrp_legacy.shims.overlay import overlay
from nrp_legacy.shims.paths import Paths

_NUMPY_NAMES = {
    "float_": "float64", "complex_": "complex128", "unicode_": "str_", "string_": "bytes_", "bool8": "bool_",
    "int0": "intp", "uint0": "uintp",
    "Inf": "inf", "Infinity": "inf", "infty": "inf", "PINF": "inf", "NaN": "nan", "NAN": "nan",
    "product": "prod", "cumproduct": "cumprod", "sometrue": "any", "alltrue": "all", "rank": "ndim",
    "row_stack": "vstack", "round_": "round", "trapz": "trapezoid", "in1d": "isin", "mat": "asmatrix",
    "alen": "size",
}  # fmt: skip
_NUMPY_TYPES = {
    "float": float, "int": int, "bool": bool, "object": object, "str": str, "complex": complex, "long": int,
    "unicode": str, "asscalar": lambda array: array.item(), "NINF": -np.inf, "math": math,
    "asfarray": lambda values, dtype=float: np.asarray(values, dtype),
    "msort": lambda values: np.sort(values, 0),
}  # fmt: skip
_WINDOWS = {name: f"windows.{name}" for name in ("gaussian", "hann", "hamming", "blackman", "hanning")}
_SCIPY_NAMES: Mapping[str, Mapping[str, str]] = {
    "scipy.signal": {**_WINDOWS, "hanning": "windows.hann"},
    "scipy.integrate": {"simps": "simpson", "trapz": "trapezoid", "cumtrapz": "cumulative_trapezoid"},
    "scipy.linalg": {"pinv2": "pinv"},
    "scipy.stats": {"nanmean": "numpy.nanmean", "nanstd": "numpy.nanstd", "nanmedian": "numpy.nanmedian"},
}


def numpy_of_old(own: Mapping[str, Any] | None = None, paths: Paths | None = None) -> ModuleType:
    """Return NumPy with the names of version 1 too.

    Args:
        own: names that replace its own.
        paths: the locations of files.
    """
    public = {name: value for name, value in vars(np).items() if not name.startswith("_")}
    names = {
        **_NUMPY_TYPES,
        **public,
        "fromstring": _from_string,
        **(_files(paths) if paths else {}),
        **(own or {}),
    }
    return overlay("numpy", names, lambda here, name: getattr(here, _NUMPY_NAMES[name]))


def _files(paths: Paths) -> dict[str, Callable[..., Any]]:
    """Return functions that read and write files, including pickled arrays of Python 2 as in old NumPy."""
    read = {name: paths.reading(getattr(np, name)) for name in ("loadtxt", "genfromtxt", "fromfile")}
    written = {
        name: paths.writing(getattr(np, name)) for name in ("save", "savetxt", "savez", "savez_compressed")
    }
    return {**read, **written, "load": paths.reading(np.load, allow_pickle=True, encoding="latin1")}


def _from_string(text: Any, dtype: Any = float, count: int = -1, sep: str = "", **more: Any) -> Any:
    """Return the numbers in a text, or, without a separator, in bytes."""
    if sep:
        return np.fromstring(text, dtype, count, sep=sep, **more)
    raw = text.encode("latin-1") if isinstance(text, str) else text
    return np.frombuffer(raw, dtype, count).copy()


def scipy_of_old(numpy: ModuleType, paths: Paths) -> dict[str, ModuleType]:
    """Return SciPy with the names that moved since, and with the images of ``scipy.misc``."""
    images = {
        "imread": paths.reading(_read_image),
        "imresize": _resized,
        "imsave": paths.writing(_save_image),
    }
    moved = {name: overlay(name, old=_moved(names)) for name, names in _SCIPY_NAMES.items()}
    return {
        **moved,
        "scipy": overlay("scipy", {"random": numpy.random}, lambda _here, name: getattr(numpy, name)),
        "scipy.misc": overlay("scipy.misc", images, real="scipy.special"),
        "scipy.ndimage": overlay("scipy.ndimage", {"imread": images["imread"]}),
        "scipy.io": overlay("scipy.io", {"loadmat": paths.reading(_load_mat)}),
    }


def _moved(names: Mapping[str, str]) -> Callable[[ModuleType, str], Any]:
    def find(here: ModuleType, name: str) -> Any:
        place, _, now = names[name].rpartition(".")
        if place == "numpy":
            return getattr(np, now)
        return getattr(getattr(here, place) if place else here, now)

    return find


def _load_mat(name: Any, **options: Any) -> Any:
    return import_module("scipy.io").loadmat(name, **options)


def _read_image(name: Any, *_values: Any, **_options: Any) -> Any:
    """Return the image in a file, with channels red, green, blue."""
    import cv2

    image = cv2.imread(str(name))
    if image is None:
        raise FileNotFoundError(name)
    return image[..., ::-1]


def _save_image(name: Any, image: Any, **_options: Any) -> None:
    import cv2

    cv2.imwrite(str(name), np.asarray(image)[..., ::-1] if np.ndim(image) > 2 else np.asarray(image))


def _resized(image: Any, size: Any, interp: str = "bilinear", **_more: Any) -> Any:
    """Return an 8-bit image with another size: a percentage, a fraction, or rows and columns."""
    import cv2

    rows, columns = np.shape(image)[:2]
    if isinstance(size, (int, float)):
        factor = size / 100 if isinstance(size, int) else size
        size = (int(rows * factor), int(columns * factor))
    way = {"nearest": cv2.INTER_NEAREST, "bicubic": cv2.INTER_CUBIC}.get(interp, cv2.INTER_LINEAR)
    return cv2.resize(np.asarray(image).astype(np.uint8), (size[1], size[0]), interpolation=way)
