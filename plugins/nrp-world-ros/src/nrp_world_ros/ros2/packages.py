"""Message packages that this ROS 2 lacks, for your own nodes.

After ``import nrp_world_ros.ros2.packages``, ``from gazebo_msgs.srv import SetModelState`` finds a package of
ROS if it is installed, else the platform's definitions.
"""

from __future__ import annotations

import sys
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

from nrp_core.errors import NrpError
from nrp_core.messages.base import type_of
from nrp_core.messages.cdr import Codec
from nrp_core.messages.generated import PACKAGES

from nrp_world_ros.ros2.definitions import PACKAGES as STANDARD
from nrp_world_ros.ros2.types import RosTypes

OWN = (*STANDARD, "dvs_msgs", "gazebo_msgs", "vision_msgs")
"""The packages that the platform defines besides those of ROS."""

_KINDS = ("msg", "srv", "action")


class _Finder(MetaPathFinder, Loader):
    """Finds the modules of these packages, unless ROS 2 has them; packages of ROS 1 have the same names."""

    def __init__(self) -> None:
        self._types = RosTypes(Codec())

    def find_spec(self, name: str, path: Any, target: Any = None) -> ModuleSpec | None:
        package, _, kind = name.partition(".")
        if package not in (*PACKAGES, *OWN) or kind not in ("", *_KINDS):
            return None
        installed = PathFinder.find_spec(package)
        places = installed.submodule_search_locations if installed else None
        if any(file for place in places or () for file in Path(place).glob("*rosidl_typesupport*")):
            return None
        return ModuleSpec(name, self, is_package=not kind)

    def exec_module(self, module: ModuleType) -> None:
        package, _, kind = module.__name__.partition(".")

        def find(short: str) -> Any:
            if short.startswith("_") or not kind:
                raise AttributeError(short)
            type_of(f"{package}/msg/{short}")
            try:
                return self._types.make(f"{package}/{kind}/{short}")
            except NrpError as error:
                raise AttributeError(str(error)) from error

        module.__getattr__ = find  # type: ignore[method-assign]


if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
    sys.meta_path.insert(0, _Finder())
