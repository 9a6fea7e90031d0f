"""Settings, and events on topics that nothing reads, which have no effect are told; others are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code, Finding

SCENE = "  scene: hall.sdf"
EXPERIMENT = "slalom_pioneer/experiment.yaml"

Slalom = Callable[[str, str, str], list[Finding]]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("seed: 1", "seed: 1", ""),
        (
            "  scene: hall.sdf",
            "  scene: hall.sdf\n  options: {image_scale: 0.1}",
            "'image_scale' has no effect",
        ),
        (SCENE, f"{SCENE}\n  options: {{renderer: raster}}", "'renderer' has no effect"),
        ("seed: 1", "seed: 1\ncsv_folder: out", "'csv_folder' has no effect: no function has a CSV recorder"),
    ],
)
def test_what_has_no_effect_is_told_with_its_line(slalom: Slalom, old: str, new: str, words: str) -> None:
    found = [one for one in slalom(EXPERIMENT, old, new) if one.code is Code.NRP279]
    assert len(found) == bool(words)
    assert all(words in one.message and one.line is not None for one in found)


def test_settings_of_images_are_right_with_a_camera(husky: Path) -> None:
    found = validate_file(husky / "experiment.yaml", ["world.options={image_scale: 0.1, renderer: raster}"])
    assert [one for one in found if one.code is Code.NRP279] == []
