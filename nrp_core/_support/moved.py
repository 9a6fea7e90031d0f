"""The packages that moved in 0.4: imports by their names of 0.3 work for one version, with a warning."""

from __future__ import annotations

import sys

# forwarding imports its modules when it meets an old name: all programs that use nrp_core import this file
TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.machinery import ModuleSpec
    from types import ModuleType

MOVED = {
    "nrp_core.brain.changes": "nrp_core.network.changes",
    "nrp_core.brain.files": "nrp_core.network.files",
    "nrp_core.brain.network.checked": "nrp_core.network.frozen_values",
    "nrp_core.brain.network": "nrp_core.network",
    "nrp_core.brain.pynn.connectivity_estimate": "nrp_core.network.pynn.connectors",
    "nrp_core.brain.pynn": "nrp_core.network.pynn",
    "nrp_core.cle.batched_loops": "nrp_lab.gym.side_by_side",
    "nrp_core.cle.time_limit": "nrp_core._support.time_limit",
    "nrp_core.pynn.control": "nrp_core.pynn.running",
    "nrp_core.pynn.recording": "nrp_core.pynn.recorder",
    "nrp_core.pynn.rewirings": "nrp_core.pynn.recorder",
    "nrp_core.pynn.trains": "nrp_core.pynn.recorder",
    "nrp_core.world.messages": "nrp_core.messages",
    "nrp_core.world.rigid": "nrp_core.scene.rigid",
    "nrp_core.world.scene": "nrp_core.scene",
}
"""Names of packages and modules in 0.3 and since; the others of a package moved with it."""


_OLD = tuple(MOVED)


def current_name(name: str) -> str:
    """Return today's dotted name of a module, which may be its name of 0.3."""
    for old, new in MOVED.items():
        if name == old or name.startswith(f"{old}."):
            return new + name[len(old) :]
    return name


def forward_old_names() -> None:
    """Let imports find moved modules by their old names; the first one warns."""
    if _Forwarding not in sys.meta_path:
        sys.meta_path.insert(0, _Forwarding)  # others find submodules by the path of a package


class _Forwarding:
    """The finder and loader of moved modules."""

    warned = False

    @classmethod
    def find_spec(cls, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        if not name.startswith(_OLD) or current_name(name) == name:
            return None
        from importlib.machinery import ModuleSpec

        return ModuleSpec(name, cls)  # type: ignore[arg-type]

    @staticmethod
    def create_module(spec: ModuleSpec) -> None:
        """Leave creation to the import system, which replaces the module by its successor."""

    @classmethod
    def exec_module(cls, module: ModuleType) -> None:
        import warnings
        from importlib import import_module

        old = module.__name__
        new = current_name(old)
        if not cls.warned:
            cls.warned = True
            warnings.warn(
                f"{old} is {new} since 0.4; the old name ends with 0.5", DeprecationWarning, stacklevel=2
            )
        sys.modules[old] = import_module(new)
