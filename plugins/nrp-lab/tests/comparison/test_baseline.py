"""A file of known differences is read as it was written, or refused with the reason."""

from __future__ import annotations

from math import inf
from pathlib import Path

import pytest
from nrp_lab.comparison.engine_verdict import Baseline

from nrp_core.errors import ExperimentError


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"experiment": "a", "known": {"x": true}}', "an amount is a number or null, not True"),
        ('{"experiment": "a", "known": {"x": "1.0"}}', "an amount is a number or null, not '1.0'"),
        ('{"experiment": "a", "known": {"x": NaN}}', "NaN is not a value in JSON"),
        ('{"experiment": "a", "known": {"x": 1, "x": 2}}', "'x' is given twice"),
        ('{"experiment": "a", "known": {}, "knwon": {}}', "it has no key 'knwon'"),
        ('{"experiment": "a"}', "it needs 'experiment' and 'known'"),
    ],
)
def test_a_baseline_with_a_mistake_is_refused_with_the_reason(tmp_path: Path, text: str, reason: str) -> None:
    path = tmp_path / "known.json"
    path.write_text(text)
    with pytest.raises(ExperimentError) as caught:
        Baseline.read(path)
    assert reason in str(caught.value)


def test_a_baseline_is_read_as_it_is_written(tmp_path: Path) -> None:
    written = Baseline("a", {"x": 1.5, "y": inf, "z": -2.0})
    written.write(tmp_path / "known.json")
    assert Baseline.read(tmp_path / "known.json", "a") == written
