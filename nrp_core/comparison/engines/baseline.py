"""Known differences in a file, so that only new ones are reported."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path

from nrp_core._support.writing import writing
from nrp_core.comparison.engines.verdict import EngineDifference, EngineVerdict
from nrp_core.errors import ExperimentError

_GROWTH = 0.25
"""A known difference may become larger by this share."""


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
            data = json.loads(path.read_text("utf-8"))
            found = cls(
                str(data["experiment"]),
                {str(k): inf if v is None else float(v) for k, v in data["known"].items()},
            )
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise ExperimentError(
                "is not a baseline: it needs 'experiment' and 'known', as nrp diff --baseline writes them",
                path=path,
            ) from error
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
