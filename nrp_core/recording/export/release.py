"""Let go of what a writer held that the disk failed."""

from __future__ import annotations

import gc
import shutil
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def nothing_left(target: Path) -> Iterator[None]:
    """Let a block write a new file or folder; where the disk fails, remove it and all that holds it.

    HDF5 writes on when its objects are freed, fails again, and each of them prints a traceback and its name:
    that is kept back, because the first failure has been raised.
    """
    hooks = sys.excepthook, sys.unraisablehook
    sys.excepthook = lambda *_: None  # for what is raised while an object is freed, since all else is caught
    sys.unraisablehook = lambda late: None if "h5py" in repr(late.object) else hooks[1](late)
    try:
        yield
    except OSError as error:
        _free(error)
        if target.is_dir():
            shutil.rmtree(target, ignore_errors=True)
        target.unlink(missing_ok=True)
        raise
    finally:
        sys.excepthook, sys.unraisablehook = hooks


def _free(error: BaseException | None) -> None:
    """Forget what the frames of an error, and of those that led to it, still hold."""
    while error is not None:
        traceback.clear_frames(error.__traceback__)
        error = error.__context__
    gc.collect()
