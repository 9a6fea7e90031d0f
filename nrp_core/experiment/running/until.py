"""The times to which a program lets a run go."""

from __future__ import annotations

import logging
from typing import Final

from nrp_core._support.checked_arguments import is_number
from nrp_core.clock import from_seconds, seconds
from nrp_core.errors import TimestepError

_LONGEST_S: Final = 1e8
"""Three years; a time in ns is larger."""
_OFTEN: Final = 10
"""Who runs an experiment for so many times its duration probably counts in ms."""
_logger = logging.getLogger(__name__)


def end_ns(t_s: float, now_ns: int, duration_ns: int) -> int:
    """Return the time to run to, and log a doubt about one far beyond the experiment.

    Args:
        t_s: the requested time, s.
        now_ns: the time reached.
        duration_ns: the duration of the experiment.

    Raises:
        TimestepError: it is not a time, or has passed.
    """
    if not is_number(t_s) or not abs(t_s) <= _LONGEST_S:
        raise TimestepError(f"cannot run to {t_s!r}: a time is a number of seconds, below {_LONGEST_S:g}")
    until_ns = from_seconds(t_s)
    if until_ns < now_ns:
        raise TimestepError(f"cannot run to {t_s:g} s: the time is {seconds(now_ns):g} s")
    if until_ns - now_ns > _OFTEN * duration_ns:
        _logger.warning(
            "the run goes to %g s, and the duration of the experiment is %g s; times of a run are in s: "
            "write %g for %g ms",
            t_s, seconds(duration_ns), t_s / 1000.0, t_s,
        )  # fmt: skip
    return until_ns
