"""Shells complete the names that commands take, and `nrp list` lists the experiments."""

import json
import os
import subprocess
import sys

import pytest

from nrp_core.cli.commands.plot import FIGURES, PANELS
from nrp_core.cli.commands.video import VIEWS
from nrp_core.experiment.reading.find import shipped
from nrp_core.findings import Code
from nrp_core.recording.figures import What
from nrp_core.recording.figures.style import Panel
from nrp_core.recording.video import ViewKind


def completed(*words: str) -> list[str]:
    """Return the proposals for the last word, as bash asks for them."""
    environment = {
        **os.environ, "_NRP_COMPLETE": "complete_bash", "COMP_WORDS": " ".join(("nrp", *words)),
        "COMP_CWORD": str(len(words)),
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-m", "nrp_core"], env=environment, capture_output=True, text=True, check=False
    )
    return done.stdout.split()


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("words", "proposals"),
    [
        (
            ("run", "braitenberg_husky/n"),
            {"no_red", "nrp_gains", "nrp_gains_no_red", "nrp_gains_right_first"},
        ),
        (("explain", "NRP28"), {f"NRP28{digit}" for digit in "0245"}),
        (
            ("explain", "slalom_pioneer", "left_to_"),
            {f"left_to_{side}" for side in ("left", "right", "other")},
        ),
        (("plot", "somewhere", "ra"), {"raster"}),
        (("plot", "somewhere", "--panels", "map,sp"), {"map,spikes"}),
        (("export", "somewhere", "--format", "n"), {"nwb"}),
        (("video", "somewhere", "--view", "f"), {"follow", "free"}),
    ],
)
def test_a_shell_completes(words: tuple[str, ...], proposals: set[str]) -> None:
    assert {one.removeprefix("braitenberg_husky/") for one in completed(*words)} == proposals


def test_completion_offers_exactly_the_valid_values() -> None:
    assert set(FIGURES) == {str(one) for one in What}
    assert set(PANELS) == {str(one) for one in Panel}
    assert set(VIEWS) == {str(one) for one in ViewKind}
    assert len(Code) >= 60


def test_all_installed_experiments_are_listed_with_their_descriptions(nrp) -> None:
    done = nrp("list")
    assert done.code == 0
    names = [line for line in done.out.splitlines() if not line.startswith(" ")]
    assert names == shipped()
    assert "    A Husky turns on the spot until it sees red." in done.out
    data = json.loads(nrp("list", "--json").out)["experiments"]
    assert [one["name"] for one in data] == names
    assert all(one["description"] and one["error"] is None for one in data)
