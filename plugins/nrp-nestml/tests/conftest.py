"""The kernels of cells run as Python here: the results are the same, and compiling them all takes minutes."""

import os

pytest_plugins = ["cases", "golden"]  # in tests/shared

os.environ.setdefault("NUMBA_DISABLE_JIT", "1")
