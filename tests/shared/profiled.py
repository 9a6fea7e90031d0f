"""Whether calls still begin under a profiler."""

from __future__ import annotations

import sys
import threading


def is_profilable(limit_s: float = 10.0) -> bool:
    """Return whether a call under a profiler returns; in a thread, because it might never."""

    def call() -> None:
        sys.setprofile(lambda *_: None)
        (lambda: None)()
        sys.setprofile(None)

    thread = threading.Thread(target=call, daemon=True)
    thread.start()
    thread.join(limit_s)
    return not thread.is_alive()
