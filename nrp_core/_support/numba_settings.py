"""Import Numba without the settings that it looks for in the working directory.

``.numba_config.yaml`` there would win over the environment. It can name a cache, whose files are pickles, so
that another user's folder would execute code in every command that imports Numba.
"""

from __future__ import annotations

import os
from typing import Any

_FILE = ".numba_config.yaml"


def _import() -> None:
    exists = os.path.exists

    def exists_elsewhere(path: Any) -> bool:
        return path != _FILE and exists(path)

    os.path.exists = exists_elsewhere
    try:
        from numba.core import config
    finally:
        os.path.exists = exists
    vars(config)["_config_fname"] = os.devnull + _FILE  # it checks again before it compiles


_import()
