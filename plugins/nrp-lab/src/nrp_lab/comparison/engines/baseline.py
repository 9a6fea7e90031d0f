"""Known differences in a file, so that only new ones are reported."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path

from nrp_core._support.strict_json import strict_json
from nrp_core._support.writing import writing
from nrp_core.errors import ExperimentError
from nrp_lab.comparison.engines.verdict import EngineDifference, EngineVerdict

_GROWTH = 0.25
"""A known difference may become larger by this share."""


def _amount(value: object) -> float:
    """Return an amount in a file.

    Raises:
        ValueError: it is neither a number nor null.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, type(None))):
        raise ValueError(f"an amount is a number or null, not {value!r}")
    return inf if value is None else float(value)


@dataclass(frozen=True, slots=True)
class Baseline:
    """The known differences of one experiment.

    Args:
        experiment: its name.
        known: amount by the key of the difference; infinite where one engine has no such signal.
    """

    experiment: str
    known: Mapping[str, float]

    @classmethod
    def of(cls, experiment: str, differences: Sequence[EngineDifference]) -> Baseline:
        """Return the baseline with all differences that matter."""
        return cls(experiment, {one.key: one.amount for one in differences if one.matters})

    @classmethod
    def read(cls, path: Path, experiment: str | None = None) -> Baseline:
        """Read a baseline.

        Raises:
            ExperimentError: the file is not one, or is one of another experiment.
        """
        try:
            data = strict_json(path.read_text("utf-8"))
            found = cls(str(data["experiment"]), {str(k): _amount(v) for k, v in data["known"].items()})
            if surplus := data.keys() - {"experiment", "known"}:
                raise ValueError(f"it has no key '{min(surplus)}'")
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            why = f" ({error})" if isinstance(error, ValueError) else ""
            needed = "it needs 'experiment' and 'known', as nrp diff --baseline writes them"
            raise ExperimentError(f"is not a baseline: {needed}{why}", path=path) from error
        if experiment is not None and found.experiment != experiment:
            raise ExperimentError(
                f"is the baseline of '{found.experiment}', not of '{experiment}'; give another file",
                path=path,
            )
        return found

    def write(self, path: Path) -> None:
        """Write it as JSON.

        Raises:
            ExperimentError: the file cannot be written.
        """
        known = {key: amount if isfinite(amount) else None for key, amount in sorted(self.known.items())}
        data = {"experiment": self.experiment, "known": known}
        with writing(path):
            path.write_text(json.dumps(data, indent=1) + "\n", "utf-8")

    def applied(self, verdict: EngineVerdict) -> EngineVerdict:
        """Return a verdict in which the known differences are marked."""
        return replace(
            verdict, differences=[replace(one, is_known=self._has(one)) for one in verdict.differences]
        )

    def _has(self, one: EngineDifference) -> bool:
        known = self.known.get(one.key)
        if known is None or known * one.amount < 0:
            return False
        return abs(one.amount) <= max(abs(known) * (1 + _GROWTH), abs(known) + one.margin / 2)
