"""Signs of synapses: the effects of transmitters, and the user's rule for unknown ones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from nrp_core.errors import NetworkError, did_you_mean
from nrp_formats.connectome.tables import chosen_column, column_names, column_texts, read_rows

EXCITATORY: Final = frozenset(
    {"ach", "acetylcholine", "da", "dopamine", "ser", "serotonin", "oct", "octopamine", "excitatorychem"}
)
INHIBITORY: Final = frozenset({"gaba", "glut", "glutamate", "histamine", "inhibitorychem"})
"""Signs in the fly: Shiu et al. (2024), and Hardie (1989, Nature 339:704) for histamine."""
EXCLUDE: Final = "exclude"
EXCITE: Final = "excite"
LEFT_OUT: Final = 2
"""The sign of edges of an excluded transmitter, which are left out whatever the type of their source."""
_WORDS: Final = {
    "excitatory": 1, "1": 1, "+1": 1, "1.0": 1, "inhibitory": -1, "-1": -1, "-1.0": -1, EXCLUDE: 0, "0": 0,
}  # fmt: skip


@dataclass(frozen=True)
class Signs:
    """The signs of transmitters and types.

    Args:
        rule: ``exclude`` or ``excite`` for all edges of unknown sign, or None.
        given: 1, -1 or 0 (exclude) by the names of types and transmitters, in lower case.
    """

    rule: str | None = None
    given: Mapping[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, unknown: str | Path | None) -> Signs:
        """Return the signs with the user's rule: ``exclude``, ``excite``, or a table of types.

        Raises:
            NetworkError: the rule is neither a word nor a table with the columns ``type`` and ``sign``.
        """
        if unknown is None or unknown in (EXCLUDE, EXCITE):
            return cls(None if unknown is None else str(unknown))
        path = Path(unknown)
        if not path.suffix:
            raise NetworkError(
                f"--unknown is '{unknown}'; it must be {EXCLUDE}, {EXCITE} or a table with the columns "
                f"type and sign{did_you_mean(str(unknown), (EXCLUDE, EXCITE))}"
            )
        return cls(None, _read(path))

    def of_transmitter(self, text: str) -> int:
        """Return 1 or -1, 0 for an unknown transmitter, or ``LEFT_OUT`` for one that the user excludes."""
        name = text.strip().lower()
        known = 1 if name in EXCITATORY else -1 if name in INHIBITORY else 0
        return self.given.get(name, known) or (LEFT_OUT if name in self.given else 0)

    def decided(self, names: Iterable[str]) -> int | None:
        """Return 1, -1 or 0 (exclude) for the edges of a cell with these names; None if it is undecided."""
        if self.rule is not None:
            return 1 if self.rule == EXCITE else 0
        return next((self.given[name.lower()] for name in names if name.lower() in self.given), None)


def _read(path: Path) -> dict[str, int]:
    names = column_names(path)
    type_column = chosen_column(path, "the type", ("type", "transmitter", "name", "class"), names)
    sign_column = chosen_column(path, "the sign", ("sign",), names)
    found: dict[str, int] = {}
    for rows in read_rows(path, [type_column, sign_column]):
        for kind, text in zip(*(column_texts(rows[one]) for one in (type_column, sign_column)), strict=True):
            if text.strip().lower() not in _WORDS:
                raise NetworkError(
                    f"the sign of '{kind}' is '{text}'; it must be excitatory, inhibitory or {EXCLUDE}",
                    path=path,
                )
            found[kind.strip().lower()] = _WORDS[text.strip().lower()]
    return found
