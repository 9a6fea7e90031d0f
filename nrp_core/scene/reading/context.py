"""The context of reading a file: its XML, the files that it refers to, its warnings, and omitted parts."""

from __future__ import annotations

import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import chain
from pathlib import Path
from typing import TypeAlias, TypeVar
from urllib.parse import unquote

from nrp_core import xml as xml_tree
from nrp_core._support.audit_events import LOOKS, SEARCHES
from nrp_core._support.text import join_with_limit
from nrp_core.errors import BackendError, SceneError
from nrp_core.findings import Code, Finding, Findings, Level, merged
from nrp_core.registry import Registry
from nrp_core.xml import Element as Element


def no_package(name: str) -> str:
    """Return the message about a ROS package that is not found."""
    return f"there is no package '{name}' in the search path"


read_xml = partial(xml_tree.read_xml, kind=SceneError)
"""Reads a file as XML; a :class:`SceneError` is raised if it is not well-formed or has a document type."""
parse_xml = partial(xml_tree.parse_xml, kind=SceneError)
"""Parses a text in the same way; the path is for messages."""


def without_lines(element: Element) -> Element:
    """Return a generated element, with all lines 1 because it is not in a file of the user.

    No line of it can be omitted; see :func:`read_without`.
    """
    element.line, element.end_line = 1, 0
    for child in element.children:
        without_lines(child)
    return element


Places: TypeAlias = Mapping[tuple[Path, int], int]
"""Number of elements to leave out by file and line, the innermost first."""
Read = TypeVar("Read")

_PARTS = frozenset(
    {"include", "model", "light", "actor", "plugin", "sensor", "visual", "collision", "joint", "link",
     "controller", "material", "inertial", "state", "physics", "scene", "gazebo", "transmission", "limit",
     "dynamics", "surface", "texture", "frame"}
)  # fmt: skip
_MOST = 300


def read_without(read: Callable[[Places], Read]) -> tuple[Read, list[Finding]]:
    """Return the contents of a file, and the findings for which elements are omitted, each once.

    Args:
        read: reads the file without the elements at some places.

    Raises:
        SceneError: the error is not in an element that can be omitted.
    """
    without: Counter[tuple[Path, int]] = Counter()
    reasons: list[Finding] = []
    last: SceneError | None = None
    while True:
        try:
            return read(without), list(
                dict.fromkeys(reasons)
            )  # a line may hold other elements that went first
        except SceneError as error:
            if error.path is None or error.line is None or len(reasons) >= _MOST:
                raise last or error from None
            last = error
            without[error.path, error.line] += 1
            reasons.append(
                Finding(Code.NRP260, f"{error.message}: left out", Level.WARNING, error.path, error.line)
            )


def leave_out(root: Element, without: Places) -> None:
    """Remove the elements at some places from a file."""
    for (path, line), count in without.items():
        if path != root.path:
            continue
        for _ in range(count):
            holder, part = _innermost(root, line)
            if holder is None:
                raise SceneError(f"{path}:{line}: no element around this line can be left out")
            holder.children = [child for child in holder.children if child is not part]


def _innermost(holder: Element, line: int) -> tuple[Element | None, Element | None]:
    """Return the innermost omissible element around a line, with its parent."""
    around = [child for child in reversed(holder.children) if child.line <= line <= child.end_line]
    for within in sorted(around, key=lambda child: child.line != line):
        found = _innermost(within, line)
        if found[1] is not None:
            return found
        if within.tag in _PARTS:
            return holder, within
    return None, None


MANIFEST = "package.xml"
_SOURCES = "src"
_DEPTH = 4
"""Folders between a workspace's ``src`` and a package."""


def in_workspace(name: str, user: Path) -> Iterator[Path]:
    """Yield the folders of a package in the workspace of a file, sources first.

    Args:
        name: the name of the package.
        user: the file that refers to it.
    """
    above = user.absolute().parents
    own = next((folder for folder in above if (folder / MANIFEST).is_file()), None)
    if own is None:
        return
    if package_name(own) == name:
        yield own
    sources = next((folder for folder in own.parents if folder.name == _SOURCES), own.parent)
    if name in (found := _packages(sources)):
        yield found[name]
    if own.parent.name == "share":
        prefix = own.parent.parent
        yield from (prefix / "share" / name, prefix.parent / name / "share" / name)


def package_name(folder: Path) -> str:
    """Return the name in the manifest of a package; empty without a manifest that can be read."""
    try:
        manifest = folder / MANIFEST
        return read_xml(manifest).word("name") if manifest.is_file() else ""
    except SceneError:
        return ""


def in_sources(file: Path) -> Path | None:
    """Return where the sources of a package have a file that its installation has at a place.

    A package may install the contents of its folder ``description`` or ``bringup`` as its own.
    """
    for root in file.parents:
        if (root / MANIFEST).is_file():
            places = (folder / file.relative_to(root) for folder in sorted(root.iterdir()))
            return next((place for place in places if place.is_file()), None)
    return None


@lru_cache(maxsize=8)
def _packages(sources: Path) -> Mapping[str, Path]:
    """Return the packages below a folder; of several with one name the least deep, the first by name."""
    found: dict[str, Path] = {}
    for depth in range(1, _DEPTH + 1):
        for manifest in sorted(sources.glob("*/" * depth + MANIFEST)):
            found.setdefault(package_name(manifest.parent), manifest.parent)
    return found


ENVIRONMENT = (
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "GAZEBO_MODEL_PATH",
    "GAZEBO_RESOURCE_PATH",
    "ROS_PACKAGE_PATH",
)
INSTALLED = "AMENT_PREFIX_PATH"
"""Variable of ROS 2: folders with installed packages in ``share``."""
SHIPPED = Path(__file__).parents[1] / "models"

_SCHEMES = ("model", "package", "file")
_FUEL = re.compile(r"(fuel\.[^/]+)/[^/]+/([^/]+)/models/([^/]+)(?:/(\d+|tip))?(?:/files)?/?(.*)")
_FUEL_CACHES = Path("~/.gz/fuel"), Path("~/.ignition/fuel")
_MAIN_FILES = (".sdf", ".world", ".urdf", ".xacro")

FindElsewhere = Callable[[str], Path | None]


class Resources:
    """The places where files are searched.

    Args:
        search_path: folders given by the user, in order.
        find_elsewhere: called with the name of a file that is in none of the places, returns it or None.
    """

    def __init__(
        self, search_path: Iterable[Path | str] = (), find_elsewhere: FindElsewhere | None = None
    ) -> None:
        self._find_elsewhere = find_elsewhere
        variables = [folder for name in ENVIRONMENT for folder in _folders_in(name)]
        installed = [folder / "share" for folder in _folders_in(INSTALLED)]
        self._of_user = [Path(folder).absolute() for folder in search_path]
        self._folders = [*self._of_user, *variables, *installed, SHIPPED]

    def find(self, uri: Element) -> Path | None:
        """Return the file that a ``<uri>`` refers to, None if it does not exist."""
        found = next((path for path in _noted(self._candidates(uri.text, uri.path)) if path.is_file()), None)
        found = found or next(filter(None, map(in_sources, self._candidates(uri.text, uri.path))), None)
        found = found or next((path for path in _noted(_beside(uri)) if path.is_file()), None)
        plain = unquote(uri.text).replace("\\", "/")  # %20 for a space, folders of Windows
        if found is None and plain != uri.text:
            return self.find(replace(uri, text=plain))
        return found or (self._find_elsewhere(uri.text) if self._find_elsewhere is not None else None)

    def media(self) -> list[Path]:
        """Return the folders of the user in which scripts of materials and their textures are looked for."""
        inner = ("", "materials/scripts", "materials/textures")
        return [place for folder in self._of_user for each in inner if (place := folder / each).is_dir()]

    def locate(self, uri: Element) -> Path | None:
        """Return the file or folder that a ``<uri>`` refers to, None if it does not exist."""
        return next((path for path in _noted(self._candidates(uri.text, uri.path)) if path.exists()), None)

    def model_file(self, uri: Element) -> Path:
        """Return the model file that a ``<uri>`` refers to, directly or by the folder of the model.

        Raises:
            SceneError: it does not exist.
        """
        if not uri.text:
            raise uri.error(f"the <{uri.tag}> is empty")
        candidates = list(self._candidates(uri.text, uri.path))
        path = next((path for path in _noted(candidates) if path.exists()), None)
        if path is None:
            folders = dict.fromkeys(str(path.parent) for path in candidates)
            looked = f"looked in {', '.join(folders)}" if folders else "only files of this machine are read"
            raise uri.error(f"there is no '{uri.text}'; {looked}")
        if not path.is_dir():
            return path
        found = listed_file(path)
        if found is None:
            raise uri.error(f"the folder {path} holds neither a model.config nor a model.sdf")
        return found

    def package(self, name: str, user: Path) -> Path:
        """Return the folder of a ROS package that a file refers to.

        Raises:
            SceneError: it does not exist.
        """
        above = user.absolute().parents
        # first the package of the file, which may have a folder for its Python modules with the same name
        own = (folder for folder in above if package_name(folder) == name)
        candidates = self._candidates(f"package://{name}", user)
        found = (folder for folder in _noted(candidates) if folder.is_dir())
        named = (folder for folder in above if folder.name == name)
        for folder in chain(own, found, named):
            return folder
        raise SceneError(no_package(name), path=user)

    def _candidates(self, uri: str, user: Path) -> Iterator[Path]:
        scheme, separator, rest = uri.partition("://")
        if scheme in ("http", "https"):
            above = user.absolute().parents  # a model on Fuel is another one than the file that includes it
            yield from (each for each in self._of_fuel(unquote(rest)) if each.absolute() not in above)
        if separator and scheme not in _SCHEMES:
            return
        beside = user.absolute().parent
        for folder in (user.parent, beside.parent, *self._folders):
            yield folder / (rest if separator else uri)
        if scheme in ("model", "package") and separator:
            name, _, inner = rest.partition("/")
            yield from (folder / inner for folder in (beside, *beside.parents) if folder.name == name)
            yield from (folder / inner for folder in (beside, beside.parent) if inner)  # another name
            if name:
                yield from (folder / inner for folder in in_workspace(name, user))
            else:  # package:///meshes/a.stl is in the package of the file
                yield from (folder / inner for folder in beside.parents)

    def _of_fuel(self, rest: str) -> Iterator[Path]:
        """Yield where a model of Gazebo Fuel may be: in the cache of Gazebo, or a folder with its name."""
        found = _FUEL.match(rest)
        if found is None:
            return
        server, owner, name, version, inner = found.groups()
        for home in _FUEL_CACHES:
            kept = home.expanduser() / server / owner.lower() / "models" / name.lower()
            versions = sorted(kept.glob("*"), key=lambda folder: (len(folder.name), folder.name))
            chosen = [folder for folder in versions if version in (None, "tip", folder.name)]
            yield from (folder / inner for folder in chosen[-1:])
        for folder in self._folders:
            yield from (folder / each / inner for each in (name, name.lower().replace(" ", "_")))


def _noted(paths: Iterable[Path]) -> Iterator[Path]:
    """Yield paths at which a file is looked for; the reading depends on whether it is there."""
    for path in paths:
        sys.audit(LOOKS, str(path))
        yield path


def _beside(uri: Element) -> Iterator[Path]:
    """Yield where the file of a missing package or another machine may stand beside the file that uses it."""
    scheme, separator, rest = uri.text.partition("://")
    if separator and scheme not in _SCHEMES:
        return
    folder, parts = uri.path.absolute().parent, Path(rest if separator else uri.text).parts
    yield from (folder.joinpath(*parts[i:]) for i in range(1, len(parts)))
    yield from (folder / "meshes" / name for name in parts[-1:])


def main_file(folder: Path) -> Path | None:
    """Return the file of the model or room in a folder: the listed one, else the one nearest its top."""
    configs = sorted(folder.rglob("model.config"), key=_depth)
    if configs:
        return listed_file(configs[0].parent)
    named = (sorted(folder.rglob(f"*{suffix}"), key=_depth) for suffix in _MAIN_FILES)
    return next((files[0] for files in named if files), None)


def listed_file(folder: Path) -> Path | None:
    """Return the SDF file with the newest version in a model's folder, None if it has none."""
    config = folder / "model.config"
    if config.exists():
        files = [(_version(sdf), folder / sdf.text) for sdf in read_xml(config).all("sdf")]
        if files:
            return max(files)[1]
    plain = folder / "model.sdf"
    return plain if plain.exists() else None


def _folders_in(variable: str) -> list[Path]:
    sys.audit(SEARCHES, variable)
    return [Path(folder) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


def _depth(path: Path) -> tuple[int, str]:
    return len(path.parts), str(path)


def _version(sdf: Element) -> tuple[int, ...]:
    return tuple(int(part) for part in sdf.attributes.get("version", "0").split(".") if part.isdigit())


class Notes:
    """The warnings of one reading; a warning about many elements is given once, with the first place."""

    def __init__(self) -> None:
        self._findings: list[tuple[Finding, str]] = []

    def warn(
        self,
        element: Element,
        code: Code,
        message: str,
        *,
        subject: str | None = None,
        alike: str = "",
        level: Level = Level.WARNING,
    ) -> None:
        """Warn of an element.

        Args:
            element: the element.
            code: the kind of the finding.
            message: what is wrong.
            subject: the name of the object concerned.
            alike: a key; findings with the same key become one per file, which names the objects.
            level: how bad it is.
        """
        finding = Finding(code, message, level, element.path, element.line, subject=subject)
        self._findings.append((finding, alike))

    def has(self, code: Code, subject: str) -> bool:
        """Return whether a subject has a warning with a code."""
        return any((each.code, each.subject) == (code, subject) for each, _ in self._findings)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All warnings; a warning about many elements is listed once, with the first place."""
        alike: dict[object, list[Finding]] = {}
        for finding, word in self._findings:
            alike.setdefault((word, finding.path) if word else id(finding), []).append(finding)
        return merged(_joined(each) for each in alike.values())


_NAMED = 3
"""How many other objects a finding names."""


def _joined(findings: Sequence[Finding]) -> Finding:
    """Merge findings into the first, with the names of the objects of the others."""
    first = findings[0]
    others = list(dict.fromkeys(each.subject for each in findings if each.subject != first.subject))
    if not others:
        return replace(first, count=len(findings))
    names = join_with_limit([f"'{name}'" for name in others], _NAMED)
    return replace(first, message=f"{first.message}; also {names}", count=len(findings))


@dataclass(frozen=True, slots=True)
class Reading:
    """The context of reading a model, passed to all readers of its parts.

    Args:
        resources: the search for meshes and included files.
        notes: collects warnings.
        robot: name of the whole model; relative topics in its file resolve below it.
        scope: the prefix of the names of parts of a nested model, ``arm::``.
        without: the elements to leave out of files.
        args: arguments of a xacro file.
        lenient: whether to omit a missing included file, with a warning instead of an error.
        opened: the roots of the files that were opened, in SDF.
        written: the same as they are written, in SDF or URDF.
    """

    resources: Resources
    notes: Notes
    robot: str = ""
    scope: str = ""
    without: Places = field(default_factory=dict)
    args: Mapping[str, object] = field(default_factory=dict)
    lenient: bool = False
    opened: list[Element] = field(default_factory=list)
    written: list[Element] = field(default_factory=list)

    def within(self, prefix: str) -> Reading:
        """Return the reading of a nested model."""
        return replace(self, scope=self.scope + prefix)

    def topic_of(self, part: str, name: str) -> str:
        """Return the default topic of a part of the model (a link, a joint)."""
        return f"{self.scope}{part}/{name}".replace("::", "/")


Reader = Callable[[Path], tuple[str, Sequence[Finding | str]]]

READERS: Registry[Reader] = Registry("nrp_core.scene_readers", "scene reader")


def added_formats() -> set[str]:
    """Return the root elements of the formats that installed packages add."""
    return set(READERS.names())


def read_added(root: Element, notes: Notes) -> Element | None:
    """Return the equivalent ``<sdf>`` of a file in another format, None without a reader of its root element.

    Raises:
        SceneError: the file cannot be used, or its reader does not import or exists twice.
    """
    if root.tag not in READERS.names():
        return None
    try:
        read = READERS.load(root.tag)
    except BackendError as error:
        raise root.error(str(error)) from error
    text, warnings = read(root.path)
    for warning in Findings(warnings):
        place = replace(root, path=warning.path or root.path, line=warning.line or root.line)
        notes.warn(place, warning.code, warning.message, subject=warning.subject)
    return without_lines(parse_xml(text.encode(), root.path))
