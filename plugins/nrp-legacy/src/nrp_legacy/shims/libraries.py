"""Libraries by their old names: OpenCV 2, NumPy and SciPy, those of Python 2, ``past`` and ``future``."""

from __future__ import annotations

import csv
import io
import logging.handlers
import math
import os
import pickle
import random
import string
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial, reduce, wraps
from importlib import import_module
from importlib.util import find_spec
from numbers import Integral
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from nrp_legacy import python2_builtins
from nrp_legacy.shims.modules import module, nothing, overlay, renamed
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
_FILTER_WINDOWS = {name: f"windows.{name}" for name in ("gaussian", "hann", "hamming", "blackman", "hanning")}
_SCIPY_NAMES: Mapping[str, Mapping[str, str]] = {
    "scipy.signal": {**_FILTER_WINDOWS, "hanning": "windows.hann"},
    "scipy.integrate": {"simps": "simpson", "trapz": "trapezoid", "cumtrapz": "cumulative_trapezoid"},
    "scipy.linalg": {"pinv2": "pinv"},
    "scipy.stats": {"nanmean": "numpy.nanmean", "nanstd": "numpy.nanstd", "nanmedian": "numpy.nanmedian"},
}


_SAMPLES = ("linspace", "logspace", "geomspace")


def _with_whole_number(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function whose number of samples may be a float, as up to NumPy 1.17."""

    @wraps(function)
    def samples(start: Any, stop: Any, num: Any = 50, *values: Any, **options: Any) -> Any:
        return function(start, stop, int(num), *values, **options)

    return samples


def old_numpy(own: Mapping[str, Any] | None = None, paths: Paths | None = None) -> ModuleType:
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
        **{name: _with_whole_number(getattr(np, name)) for name in _SAMPLES},
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


def old_scipy(numpy: ModuleType, paths: Paths) -> dict[str, ModuleType]:
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


_OF_PAST = ("basestring", "cmp", "long", "raw_input", "reload", "unichr", "unicode", "xrange")
_OF_MAPPINGS = ("items", "keys", "values")


def old_div(left: Any, right: Any) -> Any:
    """Divide as Python 2: of two integers, the quotient rounded down; arrays are divided as in Python 3."""
    are_whole = isinstance(left, Integral) and isinstance(right, Integral)
    return left // right if are_whole else left / right


def futurized_modules() -> dict[str, ModuleType]:
    """Return the modules by their names."""
    past = {name: getattr(python2_builtins, name) for name in _OF_PAST}
    utils = module(
        "future.utils",
        PY2=False,
        PY3=True,
        native_str=str,
        string_types=(str,),
        text_type=str,
        binary_type=bytes,
        integer_types=(int,),
        old_div=old_div,
        lrange=lambda *bounds: list(range(*bounds)),
        lmap=lambda *values: list(map(*values)),
        lzip=lambda *items: list(zip(*items, strict=False)),
        lfilter=lambda *values: list(filter(*values)),
        **{f"iter{name}": lambda one, name=name: iter(getattr(one, name)()) for name in _OF_MAPPINGS},
        **{f"view{name}": lambda one, name=name: getattr(one, name)() for name in _OF_MAPPINGS},
        **{f"list{name}": lambda one, name=name: list(getattr(one, name)()) for name in _OF_MAPPINGS},
    )
    return {
        "past": module("past"),
        "past.utils": module("past.utils", old_div=old_div, PY2=False, PY3=True),
        "past.builtins": overlay("past.builtins", {**past, "reduce": reduce}, real="builtins"),
        "future": module("future"),
        "future.standard_library": module(
            "future.standard_library", install_aliases=nothing, install_hooks=nothing
        ),
        "future.utils": utils,
        "future.builtins": overlay("future.builtins", real="builtins"),
    }


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
_LOG_FILES = ("RotatingFileHandler", "TimedRotatingFileHandler", "WatchedFileHandler")
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


def old_libraries(
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
    numpy = old_numpy({"random": numpy_random}, paths)
    built_in = {"open": paths.open, "file": paths.open}
    return {
        **renamed_libraries(),
        "builtins": overlay("builtins", built_in),
        "__builtin__": overlay("__builtin__", built_in, real="builtins"),
        "io": overlay("io", {"open": paths.open}),
        "pickle": overlay("pickle", _pickle()),
        "csv": overlay("csv", {"reader": _csv_reader, "DictReader": _csv_dictionaries}),
        "types": overlay("types", _TYPES),
        **_logging(paths),
        "numpy": numpy,
        "numpy.random": numpy_random,
        **old_scipy(numpy, paths),
        "random": overlay("random", _methods(random.Random(seed))),
        "cv2": overlay("cv2", _headless(paths), _opencv),
        **_fonts(),
        "cv2.cv": overlay("cv2.cv", old=_opencv, real="cv2"),
        **_os(environment, paths),
        **_tables(paths),
        "glob": overlay("glob", {"glob": paths.glob}),
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


_READERS = "read_csv", "read_excel", "read_hdf", "read_json", "read_pickle", "read_table"


def _tables(paths: Paths) -> dict[str, ModuleType]:
    """Return the installed modules that read files of tables."""

    def reader(name: str) -> Callable[..., Any]:
        return paths.reading(lambda *values, **more: getattr(import_module("pandas"), name)(*values, **more))

    def file(name: Any, mode: str = "r", *values: Any, **more: Any) -> Any:
        path = paths.there(name) if mode.startswith("r") else paths.place(name)
        return import_module("h5py").File(path, mode, *values, **more)

    found = {"pandas": {name: reader(name) for name in _READERS}, "h5py": {"File": file}}
    return {name: overlay(name, own) for name, own in found.items() if find_spec(name)}


def _logging(paths: Paths) -> dict[str, ModuleType]:
    """Return the modules whose log files are placed where they can be written."""

    def placed(kind: type) -> type:
        class Placed(kind):  # type: ignore[misc]
            def __init__(self, filename: Any, *values: Any, **options: Any) -> None:
                super().__init__(paths.place(filename), *values, **options)

        Placed.__name__ = Placed.__qualname__ = kind.__name__
        return Placed

    def configure(**options: Any) -> None:
        logging.basicConfig(**{**options, "filename": paths.place(options.get("filename"))})

    kinds = {name: placed(getattr(logging.handlers, name)) for name in _LOG_FILES}
    handlers = overlay("logging.handlers", kinds)
    own = {"FileHandler": placed(logging.FileHandler), "basicConfig": configure, "handlers": handlers}
    return {"logging": overlay("logging", own), "logging.handlers": handlers}


def _string() -> dict[str, Any]:
    methods = {name: partial(_method, name) for name in _STRING_METHODS}
    letters = {"letters": string.ascii_letters, "lowercase": string.ascii_lowercase}
    more = {"uppercase": string.ascii_uppercase, "maketrans": str.maketrans, "atoi": int, "atof": float}
    return {**methods, **letters, **more, "join": lambda words, sep=" ": sep.join(words)}


def _method(name: str, text: str, *values: Any) -> Any:
    return getattr(text, name)(*values)
