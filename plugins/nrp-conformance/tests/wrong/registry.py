"""Which wrong backends there are, and which tests must find them."""

from __future__ import annotations

from collections.abc import Callable

Found = dict[type, frozenset[str]]


def register(found: Found, opener: type, attribute: str) -> Callable[..., Callable[[type], type]]:
    """Return a decorator that registers a wrong backend, or a simulation for one, with its tests.

    Args:
        found: where it is registered.
        opener: a backend that opens what its ``attribute`` names.
        attribute: likewise.
    """

    def found_by(*tests: str) -> Callable[[type], type]:
        def keep(cls: type) -> type:
            is_backend = issubclass(cls, opener)
            backend = cls if is_backend else type(cls.__name__, (opener,), {attribute: cls})
            found[backend] = frozenset(f"test_{test}" for test in tests)
            return cls

        return keep

    return found_by
