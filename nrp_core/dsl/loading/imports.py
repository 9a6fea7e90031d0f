"""The modules that transfer functions import by their usual names.

Inside a transfer function file the message packages of ROS are always ours, even if ROS is installed: ROS 2's
classes take no positional arguments and corrupt an integer that is stored in a float field. In
plain scripts an installed ROS comes first.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import importlib.util
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import CodeType, ModuleType

from nrp_core.dsl.parameters.messages import message_packages, service_packages
from nrp_core.scripts import Missing, Scope
from nrp_core.world.messages import cv_bridge, point_cloud2


def file_scope(
    framework: ModuleType,
    substitutes: Mapping[str, ModuleType] | None = None,
    folders: Iterable[Path] = (),
    missing: Missing | None = None,
    compiled: Callable[[Path], CodeType] | None = None,
) -> Scope:
    """Return the scope of a transfer function file.

    Args:
        framework: the module that ``import hbp_nrp_client.tf_framework`` returns.
        substitutes: further modules by their dotted names.
        folders: where modules are searched for that are not beside the file.
        missing: returns a substitute for a module that is not found.
        compiled: compiles an imported file; by default as Python.
    """
    known = {f"{name}.msg": package.msg for name, package in message_packages().items()}
    known |= {f"{name}.srv": services for name, services in service_packages().items()}
    known |= {"cv_bridge": cv_bridge}
    known |= dict.fromkeys(("sensor_msgs.point_cloud2", "sensor_msgs_py.point_cloud2"), point_cloud2)
    known |= {"hbp_nrp_client.tf_framework": framework, **(substitutes or {})}
    packages = {name.partition(".")[0] for name in known if "." in name} - known.keys()
    return Scope(packages, known.get, folders, missing, compiled)


class _MessageFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds the message packages if they are not installed."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        package, _, rest = fullname.partition(".")
        if rest not in _parts_of(package):
            return None
        return importlib.util.spec_from_loader(fullname, self, is_package=not rest)

    def exec_module(self, module: ModuleType) -> None:
        package, _, rest = module.__name__.partition(".")
        if rest:
            types = _parts_of(package)[rest]
            vars(module).update({"__getattr__": partial(getattr, types), "__dir__": types.__dir__})


def _parts_of(package: str) -> dict[str, ModuleType]:
    """Return a package under the empty name and its modules under theirs; nothing for another name."""
    parts = {}
    if package in message_packages():
        parts["msg"] = message_packages()[package].msg
    if package in service_packages():
        parts["srv"] = service_packages()[package]
    return {"": ModuleType(package), **parts} if parts else {}


def provide_messages() -> None:
    """Make ``import geometry_msgs.msg`` work in plain scripts and notebooks without ROS."""
    if not any(isinstance(finder, _MessageFinder) for finder in sys.meta_path):
        sys.meta_path.append(_MessageFinder())
