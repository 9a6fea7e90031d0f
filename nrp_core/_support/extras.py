"""Packages that only some commands need."""

from __future__ import annotations

from importlib.util import find_spec

from nrp_core.errors import BackendLoadError


def require_extra(module: str, requirement: str, what: str) -> None:
    """Refuse to go on without a package that an extra installs.

    Args:
        module: the name under which it is imported.
        requirement: the distribution and its extra, as in ``nrp-lab[gym]``.
        what: the thing that needs it, for the message.

    Raises:
        BackendLoadError: it is not installed; the message has the command that installs it.
    """
    try:
        found = find_spec(module)
    except ValueError:  # it was made unavailable in this process
        found = None
    if found is None:
        raise BackendLoadError(f"{what} needs {module}", remedy=f"pip install '{requirement}'")
