"""The driver that imports one plugin by name; a separate module because stevedore takes 30 ms to import."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from typing import Any

from stevedore.driver import DriverManager
from stevedore.exception import NoMatches

from nrp_core._support.packages import entries

__all__ = ["Driver", "NoMatches"]


class Driver(DriverManager[Any]):
    """Stevedore's driver, reading the metadata itself.

    Its on-disk cache misses changes of the last minutes and forgets which distribution an entry
    point came from.
    """

    def __init__(self, group: str, name: str) -> None:
        super().__init__(group, name, on_load_failure_callback=_raise)

    def list_entry_points(self) -> list[EntryPoint]:
        # an interrupted pip leaves a folder behind that lists a distribution's entries a second time
        return list(dict.fromkeys(entries(self.namespace)))


def _raise(_manager: object, _entry: EntryPoint, error: BaseException) -> None:
    raise error
