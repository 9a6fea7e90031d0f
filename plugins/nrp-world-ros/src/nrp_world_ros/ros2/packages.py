"""Message packages that this ROS 2 lacks, for your own nodes.

After ``import nrp_world_ros.ros2.packages``, ``from gazebo_msgs.srv import SetModelState`` finds a package of
ROS if it is installed, else the platform's definitions.
"""

from __future__ import annotations

import sys
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
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
    """Finds the modules of these packages, after all others."""

    def __init__(self) -> None:
        self._types = RosTypes(Codec())

    def find_spec(self, name: str, path: Any, target: Any = None) -> ModuleSpec | None:
        package, _, kind = name.partition(".")
        if package not in (*PACKAGES, *OWN) or kind not in ("", *_KINDS):
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
    sys.meta_path.append(_Finder())
