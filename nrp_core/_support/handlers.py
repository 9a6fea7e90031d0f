"""The functions ``signal`` and ``getsignal``, which every step of the loop calls.

Those of the module :mod:`signal` also look up each handler in an enum, in Python 3.11 at 4 us a call.
"""

from _signal import SIG_DFL, getsignal, signal  # type: ignore[import-not-found]

__all__ = ["SIG_DFL", "getsignal", "signal"]
