"""Libraries under the names that they had when experiments were written: NumPy 1, OpenCV 2, Python 2."""

from __future__ import annotations

import os
import random
import string
from collections.abc import Callable, Mapping
from functools import partial
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np

from nrp_legacy.shims.modules import module

_RENAMED = {
    "cPickle": "pickle", "Queue": "queue", "StringIO": "io", "cStringIO": "io",
    "ConfigParser": "configparser",
    "__builtin__": "builtins", "urllib2": "urllib.request", "urlparse": "urllib.parse",
    "httplib": "http.client", "thread": "_thread", "commands": "subprocess", "SocketServer": "socketserver",
}  # fmt: skip
"""Modules of Python 2 by the names that they have now."""
_NUMPY_NAMES = {
    "float_": "float64", "complex_": "complex128", "unicode_": "str_", "string_": "bytes_",
    "Inf": "inf", "Infinity": "inf", "infty": "inf", "PINF": "inf", "NaN": "nan", "NAN": "nan",
    "product": "prod", "cumproduct": "cumprod", "sometrue": "any", "alltrue": "all", "rank": "ndim",
    "row_stack": "vstack", "round_": "round", "trapz": "trapezoid", "in1d": "isin", "mat": "asmatrix",
}  # fmt: skip
_NUMPY_TYPES = {
    "float": float, "int": int, "bool": bool, "object": object, "str": str, "complex": complex, "long": int,
    "unicode": str, "asscalar": lambda array: array.item(),
}  # fmt: skip
_WINDOWS = (
    "imshow", "namedWindow", "destroyWindow", "destroyAllWindows", "moveWindow", "resizeWindow",
    "startWindowThread", "setMouseCallback", "createTrackbar",
)  # fmt: skip
"""Functions of OpenCV that show something on a screen; there is none."""
_STRING_METHODS = ("join", "split", "replace", "lower", "upper", "strip", "find", "count", "capitalize")


def overlay(
    name: str,
    own: Mapping[str, Any] | None = None,
    old: Callable[[ModuleType, str], Any] | None = None,
    *,
    real: str | None = None,
) -> ModuleType:
    """Return a module with the names of a real one, which is imported when one of them is used.

    Args:
        name: its name.
        own: names that replace those of the real one.
        old: returns what a name was that the real one has no longer; raises ``AttributeError`` or
            ``KeyError`` for none.
        real: the name of the real one, where that differs.
    """
    made = module(name, **(own or {}))

    def attribute(child: str) -> Any:
        here = import_module(real or name)
        try:
            return getattr(here, child)
        except AttributeError:
            if old is None:
                raise
        try:
            return old(here, child)
        except KeyError:
            raise AttributeError(f"module '{name}' has no attribute '{child}'") from None

    vars(made)["__getattr__"] = attribute
    vars(made)["__dir__"] = lambda: sorted({*vars(made), *dir(import_module(real or name))})
    return made


def libraries_of_old(
    environment: Mapping[str, str], sleep: Callable[[float], None], seed: int, import_path: list[str]
) -> dict[str, ModuleType]:
    """Return the modules that differ for experiments, by their names.

    Args:
        environment: variables that the platform set.
        sleep: waits for some seconds of simulated time.
        seed: of what is random, any integer.
        import_path: what is ``sys.path``.
    """
    chance = np.random.RandomState(seed % 2**32)
    numpy_random = overlay("numpy.random", _methods(chance))
    plain_random = overlay("random", _methods(random.Random(seed)))
    return {
        **{name: overlay(name, real=real) for name, real in _RENAMED.items()},
        "numpy": numpy_of_old({"random": numpy_random}),
        "numpy.random": numpy_random,
        "random": plain_random,
        "cv2": overlay("cv2", _headless(), _opencv),
        "os": _os(environment),
        "scipy.misc": overlay(
            "scipy.misc", {"imread": _read_image, "imresize": _resized, "imsave": _save_image}
        ),
        "sys": overlay(
            "sys",
            {"path": import_path, "setdefaultencoding": _nothing, "exc_clear": _nothing},
            _renamed(maxint="maxsize"),
        ),
        "string": overlay("string", _string()),
        "itertools": overlay(
            "itertools", {"izip": zip, "imap": map, "ifilter": filter}, _renamed(izip_longest="zip_longest")
        ),
        "collections": overlay(
            "collections", old=lambda _here, name: vars(import_module("collections.abc"))[name]
        ),
        "time": overlay("time", {"sleep": sleep}, _renamed(clock="perf_counter")),
    }


def numpy_of_old(own: Mapping[str, Any] | None = None) -> ModuleType:
    """Return NumPy with the names of version 1 too."""
    public = {name: value for name, value in vars(np).items() if not name.startswith("_")}
    names = {**_NUMPY_TYPES, **public, "fromstring": _from_string, **(own or {})}
    return overlay("numpy", names, lambda here, name: getattr(here, _NUMPY_NAMES[name]))


def _from_string(text: Any, dtype: Any = float, count: int = -1, sep: str = "", **more: Any) -> Any:
    """Return the numbers in a text, or, without a separator, in bytes."""
    if sep:
        return np.fromstring(text, dtype, count, sep=sep, **more)
    raw = text.encode("latin-1") if isinstance(text, str) else text
    return np.frombuffer(raw, dtype, count).copy()


def _methods(generator: Any) -> dict[str, Any]:
    return {name: getattr(generator, name) for name in dir(generator) if not name.startswith("_")}


def _headless() -> dict[str, Any]:
    return {**dict.fromkeys(_WINDOWS, _nothing), "waitKey": lambda *_delay: -1}


def _opencv(here: ModuleType, name: str) -> Any:
    """Return what a name of OpenCV 2 stands for: ``cv2.cv.CV_AA``, ``cv2.SimpleBlobDetector``."""
    if name == "cv":
        return overlay("cv2.cv", old=_opencv, real="cv2")
    plain = name.removeprefix("CV_")
    known = {"AA": "LINE_AA", "LOAD_IMAGE_COLOR": "IMREAD_COLOR", "LOAD_IMAGE_GRAYSCALE": "IMREAD_GRAYSCALE"}
    if plain == name:
        raise KeyError(name)
    return getattr(here, known.get(plain, plain if hasattr(here, plain) else f"COLOR_{plain}"))


def _read_image(name: Any, **_options: Any) -> Any:
    """Return a picture of a file, its channels red, green, blue."""
    import cv2

    image = cv2.imread(str(name))
    if image is None:
        raise FileNotFoundError(name)
    return image[..., ::-1]


def _save_image(name: Any, image: Any, **_options: Any) -> None:
    import cv2

    cv2.imwrite(str(name), np.asarray(image)[..., ::-1] if np.ndim(image) > 2 else np.asarray(image))


def _resized(image: Any, size: Any, interp: str = "bilinear", **_more: Any) -> Any:
    """Return a picture of 8 bits of another size: a percentage, a fraction, or rows and columns."""
    import cv2

    rows, columns = np.shape(image)[:2]
    if isinstance(size, (int, float)):
        factor = size / 100 if isinstance(size, int) else size
        size = (int(rows * factor), int(columns * factor))
    way = {"nearest": cv2.INTER_NEAREST, "bicubic": cv2.INTER_CUBIC}.get(interp, cv2.INTER_LINEAR)
    return cv2.resize(np.asarray(image).astype(np.uint8), (size[1], size[0]), interpolation=way)


def _os(environment: Mapping[str, str]) -> ModuleType:
    variables = {**environment, **os.environ}

    def expanded(path: str) -> str:
        for name in sorted(variables, key=len, reverse=True):
            path = path.replace(f"${{{name}}}", variables[name]).replace(f"${name}", variables[name])
        return path

    path = overlay("os.path", {"expandvars": expanded})
    own = {"environ": variables, "getenv": variables.get, "getcwdu": os.getcwd, "path": path}
    return overlay("os", own)


def _string() -> dict[str, Any]:
    methods = {name: partial(_method, name) for name in _STRING_METHODS}
    letters = {"letters": string.ascii_letters, "lowercase": string.ascii_lowercase}
    more = {"uppercase": string.ascii_uppercase, "maketrans": str.maketrans, "atoi": int, "atof": float}
    return {**methods, **letters, **more, "join": lambda words, sep=" ": sep.join(words)}


def _method(name: str, text: str, *values: Any) -> Any:
    return getattr(text, name)(*values)


def _renamed(**names: str) -> Callable[[ModuleType, str], Any]:
    return lambda here, name: getattr(here, names[name])


def _nothing(*_values: Any, **_fields: Any) -> None:
    """Do what needs not be done here."""
