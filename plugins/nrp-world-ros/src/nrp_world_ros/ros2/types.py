"""Classes of ROS 2 for the platform's messages: those of this installation, else made by its generators.

Making a package takes some seconds and a C++ compiler; it is kept for later processes.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
from hashlib import sha256
from importlib import import_module, invalidate_caches
from importlib.metadata import version
from pathlib import Path
from shutil import rmtree
from typing import Any

from nrp_core.errors import BackendLoadError, TopicError
from nrp_core.messages.cdr import Codec

_SERVICE = "service_msgs"
"""The package of a type in each service, with which ROS reports its calls."""

_TYPE, _FIELD = re.compile(r"\w+/msg/[A-Z][A-Za-z0-9]*$"), re.compile(r"[a-z](_?[a-z0-9])*$")

_made: dict[str, Path] = {}


class RosTypes:
    """The classes of messages and services.

    Args:
        codec: has the definitions.
    """

    def __init__(self, codec: Codec) -> None:
        self._codec = codec

    def message(self, name: str) -> Any:
        """Return the class of a message type, ``package/msg/Type``.

        Raises:
            TopicError: this ROS has a type of that name with other fields.
            BackendLoadError: it lacks the type, which cannot be made.
        """
        package, _, short = name.split("/")
        cls = self._class(package, "msg", short)
        self._compare(name, cls)
        return cls

    def service(self, request: str, response: str) -> Any:
        """Return the class of a service with these types, ``package/msg/NameRequest`` and ``...Response``.

        Raises:
            TopicError: this ROS has a service of that name with other fields.
            BackendLoadError: it lacks the service, which cannot be made.
        """
        package, _, short = request.split("/")
        cls = self._class(package, "srv", short.removesuffix("Request"))
        self._compare(request, cls.Request)
        self._compare(response, cls.Response)
        return cls

    def _class(self, package: str, kind: str, short: str) -> Any:
        found = _installed(package, kind, short)
        if found is None and package not in _made:
            self._make(package)
            found = _installed(package, kind, short)
        if found is None:
            raise TopicError(f"this installation of ROS 2 has {package}, but without {short}")
        return found

    def _compare(self, name: str, cls: Any) -> None:
        theirs, ours = list(cls.get_fields_and_field_types()), self._codec.fields(name)
        if theirs and theirs != [field.name for field in ours]:
            raise TopicError(
                f"{name} has the fields {theirs} in this ROS 2, but {[field.name for field in ours]} here"
            )

    # -- packages that this ROS lacks

    def _make(self, package: str) -> None:
        files = self._files(package)
        others = {line.split("/")[0] for text in files.values() for line in text.splitlines() if "/" in line}
        others = (others | {_SERVICE, "builtin_interfaces"}) - {package}
        for other in others:
            if not _is_installed(other):
                self._make(other)
        prefixes = [*(_made[other] for other in others if other in _made), *_prefixes()]
        environment = f"{version('rclpy')} {sysconfig.get_config_var('EXT_SUFFIX')} {prefixes}"
        key = sha256(f"{environment}{sorted(files.items())}".encode()).hexdigest()[:16]
        folder = _cache() / f"{package}-{key}"
        if not folder.is_dir():
            _generate(folder, package, files, sorted(others), prefixes)
        _made[package] = folder
        sys.path.insert(0, str(folder / "python"))
        invalidate_caches()

    def _files(self, package: str) -> dict[str, str]:
        """Return the definitions of all known types of a package, by file name."""
        names = [name for name in self._codec.names() if name.startswith(f"{package}/")]
        texts = {name.rpartition("/")[2]: self._definition(name) for name in names if self._has_names(name)}
        files = {}
        for short, text in texts.items():
            base = short.removesuffix("Request").removesuffix("Response")
            request, response = texts.get(f"{base}Request"), texts.get(f"{base}Response")
            if request is not None and response is not None:
                files[f"srv/{base}.srv"] = f"{request}\n---\n{response}"
            else:
                files[f"msg/{short}.msg"] = text
        return files

    def _definition(self, name: str) -> str:
        """Return the definition of a type without those of the types in it."""
        return self._codec.definition(name).partition("=" * 80)[0]

    def _has_names(self, name: str) -> bool:
        """Return whether the names of a type and its fields are permitted in ROS 2."""
        fields = self._codec.fields(name)
        return bool(_TYPE.match(name)) and all(_FIELD.match(field.name) for field in fields)


def _installed(package: str, kind: str, short: str) -> Any:
    """Return a class of this ROS; one of ROS 1, or of the platform, which stands in for it, is not meant."""
    before = set(sys.modules)
    try:
        module = import_module(f"{package}.{kind}")
    except ImportError:
        return None
    cls = getattr(module, short, None)
    if hasattr(type(cls), "_TYPE_SUPPORT"):
        return cls
    for name in sys.modules.keys() - before:
        if name.partition(".")[0] == package:
            del sys.modules[name]
    return None


def _is_installed(package: str) -> bool:
    return package in _made or any((prefix / "share" / package).is_dir() for prefix in _prefixes())


def _prefixes() -> list[Path]:
    """Return the folders of the installation of ROS: those of its set-up script, else that of its wheels."""
    import rclpy

    given = [Path(each) for each in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if each]
    return given or [Path(rclpy.__file__).parents[4]]


def _cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "nrp-world-ros"


def _generate(
    folder: Path, package: str, files: dict[str, str], others: list[str], prefixes: list[Path]
) -> None:
    print(f"making {package} for ROS 2, once; this takes up to a minute ...", file=sys.stderr, flush=True)
    building = folder.with_name(f"{folder.name}.{os.getpid()}")
    for name, text in files.items():
        file = building / "share" / package / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    done = subprocess.run(
        [sys.executable, "-P", "-m", "nrp_world_ros.ros2.generate", str(building), package, *others],
        env={**os.environ, "AMENT_PREFIX_PATH": os.pathsep.join(map(str, prefixes))},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        rmtree(building)
        last = done.stderr.strip().splitlines()[-1:]
        raise BackendLoadError(
            f"{package} is not in this installation of ROS 2, and cannot be made: {' '.join(last)}",
            remedy="apt-get install g++ python3-dev",
        )
    rmtree(building / "source")
    try:
        building.rename(folder)
    except OSError:  # another process was faster
        rmtree(building)
