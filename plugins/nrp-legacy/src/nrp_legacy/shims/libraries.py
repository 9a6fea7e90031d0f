"""Libraries by their old names: OpenCV 2, and those of Python 2."""

from __future__ import annotations

import csv
import io
import os
import pickle
import random
import string
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from nrp_legacy.shims.numbers import numpy_of_old, scipy_of_old
from nrp_legacy.shims.overlay import nothing, overlay, renamed
from nrp_legacy.shims.paths import Paths

_RENAMED = {
    "Queue": "queue", "StringIO": "io", "cStringIO": "io", "ConfigParser": "configparser",
    "urllib2": "urllib.request", "urlparse": "urllib.parse", "httplib": "http.client", "thread": "_thread",
    "commands": "subprocess", "SocketServer": "socketserver", "Tkinter": "tkinter",
    "copy_reg": "copyreg", "dummy_thread": "_thread", "anydbm": "dbm",
}  # fmt: skip
"""Modules of Python 2 by the names that they have now."""
_WINDOWS = (
    "imshow", "namedWindow", "destroyWindow", "destroyAllWindows", "moveWindow", "resizeWindow",
    "startWindowThread", "setMouseCallback", "createTrackbar", "setWindowTitle",
)  # fmt: skip
"""Functions of OpenCV that show something on a screen; there is none."""
_STRING_METHODS = ("join", "split", "replace", "lower", "upper", "strip", "find", "count", "capitalize")
_TYPES = {
    "StringType": str, "UnicodeType": str, "StringTypes": (str,), "IntType": int, "LongType": int,
    "FloatType": float, "ListType": list, "TupleType": tuple, "DictType": dict, "BooleanType": bool,
    "InstanceType": object, "ObjectType": object, "ClassType": type, "TypeType": type,
}  # fmt: skip


def renamed_libraries() -> dict[str, ModuleType]:
    """Return the modules of Python 2 that have another name today."""
    renamed_ones = {name: overlay(name, real=real) for name, real in _RENAMED.items()}
    return {**renamed_ones, "cPickle": overlay("cPickle", _pickle(), real="pickle")}


def libraries_of_old(
    environment: Mapping[str, str],
    sleep: Callable[[float], None],
    seed: int,
    import_path: list[str],
    paths: Paths,
) -> dict[str, ModuleType]:
    """Return the modules that differ for experiments, by their names.

    Args:
        environment: variables that the platform set.
        sleep: waits for some seconds of simulated time.
        seed: the seed of random numbers, any integer.
        import_path: ``sys.path`` of the code.
        paths: the locations of files.
    """
    chance = np.random.RandomState(seed % 2**32)
    numpy_random = overlay("numpy.random", _methods(chance))
    numpy = numpy_of_old({"random": numpy_random}, paths)
    built_in = {"open": paths.open, "file": paths.open}
    return {
        **renamed_libraries(),
        "builtins": overlay("builtins", built_in),
        "__builtin__": overlay("__builtin__", built_in, real="builtins"),
        "io": overlay("io", {"open": paths.open}),
        "pickle": overlay("pickle", _pickle()),
        "csv": overlay("csv", {"reader": _csv_reader, "DictReader": _csv_dictionaries}),
        "types": overlay("types", _TYPES),
        "numpy": numpy,
        "numpy.random": numpy_random,
        **scipy_of_old(numpy, paths),
        "random": overlay("random", _methods(random.Random(seed))),
        "cv2": overlay("cv2", _headless(paths), _opencv),
        **_fonts(),
        "cv2.cv": overlay("cv2.cv", old=_opencv, real="cv2"),
        **_os(environment, paths),
        "sys": overlay(
            "sys",
            {"path": import_path, "setdefaultencoding": nothing, "exc_clear": nothing},
            renamed(maxint="maxsize"),
        ),
        "string": overlay("string", _string()),
        "itertools": overlay(
            "itertools", {"izip": zip, "imap": map, "ifilter": filter}, renamed(izip_longest="zip_longest")
        ),
        "collections": overlay(
            "collections", old=lambda _here, name: vars(import_module("collections.abc"))[name]
        ),
        "time": overlay("time", {"sleep": sleep}, renamed(clock="perf_counter")),
    }


def _methods(generator: Any) -> dict[str, Any]:
    return {name: getattr(generator, name) for name in dir(generator) if not name.startswith("_")}


# -- OpenCV


def _headless(paths: Paths) -> dict[str, Any]:
    def real(name: str) -> Callable[..., Any]:
        return lambda *values, **options: getattr(import_module("cv2"), name)(*values, **options)

    files = {"imread": paths.reading(real("imread")), "imwrite": paths.writing(real("imwrite"))}
    return {**dict.fromkeys(_WINDOWS, nothing), **files, "waitKey": lambda *_delay: -1}


def _opencv(here: ModuleType, name: str) -> Any:
    """Return the present object for a name of OpenCV 2: ``cv2.cv.CV_AA``, ``cv2.xfeatures2d.SIFT_create``."""
    if name == "cv":
        return overlay("cv2.cv", old=_opencv, real="cv2")
    if name == "xfeatures2d":
        return here
    small = f"{name[0].lower()}{name[1:]}"  # cv2.cv.BoxPoints
    if hasattr(here, small):
        return getattr(here, small)
    plain = name.removeprefix("CV_")
    known = {"AA": "LINE_AA", "LOAD_IMAGE_COLOR": "IMREAD_COLOR", "LOAD_IMAGE_GRAYSCALE": "IMREAD_GRAYSCALE"}
    if plain == name:
        raise KeyError(name)
    return getattr(here, known.get(plain, plain if hasattr(here, plain) else f"COLOR_{plain}"))


# -- fonts


def _fonts() -> dict[str, ModuleType]:
    """Return PIL with fonts found by their names on other machines: the same font, else a similar one."""

    def truetype(font: Any = None, *values: Any, **options: Any) -> Any:
        real = import_module("PIL.ImageFont").truetype
        try:
            return real(font, *values, **options)
        except OSError:
            return real(_font_file(str(font)), *values, **options)

    fonts = overlay("PIL.ImageFont", {"truetype": truetype})
    whole = overlay("PIL", {"ImageFont": fonts}, lambda _here, name: import_module(f"PIL.{name}"))
    return {"PIL": whole, "PIL.ImageFont": fonts}


def _font_file(name: str) -> str:
    """Return the file of the font most similar to one by name, such as ``Ubuntu-B.ttf``."""
    from matplotlib.font_manager import FontProperties, findfont

    family, _, style = Path(name).stem.partition("-")
    weight = "bold" if style.lower().startswith("b") or "bold" in name.lower() else "normal"
    return str(findfont(FontProperties(family=family, weight=weight)))


# -- Python


def _pickle() -> dict[str, Any]:
    """Return functions that accept pickles of Python 2, and files opened as text."""

    def load(file: Any, **options: Any) -> Any:
        return pickle.load(_binary(file), **{"encoding": "latin1", **options})

    def loads(content: Any, **options: Any) -> Any:
        raw = content.encode("latin-1") if isinstance(content, str) else content
        return pickle.loads(raw, **{"encoding": "latin1", **options})

    def dump(content: Any, file: Any, *protocol: Any) -> None:
        pickle.dump(content, _binary(file), *protocol)

    return {"load": load, "loads": loads, "dump": dump}


def _binary(file: Any) -> Any:
    return file.buffer if isinstance(file, io.TextIOWrapper) else file


def _lines(file: Iterable[Any]) -> Iterator[str]:
    for line in file:
        yield line.decode("utf-8", "surrogateescape") if isinstance(line, bytes) else line


def _csv_reader(file: Iterable[Any], *values: Any, **options: Any) -> Any:
    return csv.reader(_lines(file), *values, **options)


def _csv_dictionaries(file: Iterable[Any], *values: Any, **options: Any) -> Any:
    return csv.DictReader(_lines(file), *values, **options)


def _os(environment: Mapping[str, str], paths: Paths) -> dict[str, ModuleType]:
    variables = {**environment, **os.environ}

    def expanded(path: str) -> str:
        for name in sorted(variables, key=len, reverse=True):
            path = path.replace(f"${{{name}}}", variables[name]).replace(f"${name}", variables[name])
        return path

    found = {name: paths.reading(getattr(os.path, name)) for name in ("exists", "isfile", "isdir", "getsize")}
    path = overlay("os.path", {"expandvars": expanded, **found})
    own = {
        "environ": variables, "getenv": variables.get, "getcwdu": os.getcwd, "path": path,
        "listdir": paths.reading(os.listdir),
    }  # fmt: skip
    return {"os": overlay("os", own), "os.path": path}


def _string() -> dict[str, Any]:
    methods = {name: partial(_method, name) for name in _STRING_METHODS}
    letters = {"letters": string.ascii_letters, "lowercase": string.ascii_lowercase}
    more = {"uppercase": string.ascii_uppercase, "maketrans": str.maketrans, "atoi": int, "atof": float}
    return {**methods, **letters, **more, "join": lambda words, sep=" ": sep.join(words)}


def _method(name: str, text: str, *values: Any) -> Any:
    return getattr(text, name)(*values)
