"""Names in recordings of earlier versions that have changed since."""

from __future__ import annotations

import pickle
from io import BytesIO
from typing import Any, Final

MOVED: Final[dict[str, str]] = {}
"""Old and new dotted names of modules, and of classes that changed their names or left their modules.

Only of classes that calls from outside pickle: messages, models and their parts, motions, lights, sensors
and drives.
"""


def loads(data: bytes) -> Any:
    """Return the object in a pickle of this or an earlier version.

    Args:
        data: the pickle; like the recorded experiment, it can run any code.
    """
    return _Unpickler(BytesIO(data)).load()


class _Unpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        full_name = f"{MOVED.get(module, module)}.{name}"
        module, _, name = MOVED.get(f"{module}.{name}", full_name).rpartition(".")
        return super().find_class(module, name)
