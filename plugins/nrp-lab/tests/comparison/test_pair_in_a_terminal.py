"""Two recordings side by side, as a terminal shows them."""

from io import StringIO
from types import SimpleNamespace
from typing import Any

from nrp_lab.comparison.divergence import Divergence
from nrp_lab.comparison.metric import all_metrics
from nrp_lab.comparison.report import print_pair
from nrp_lab.comparison.result import Measured, PairDiff
from rich.console import Console

from nrp_core.recording.reading.steps import Difference


def told(pair: PairDiff) -> str:
    console = Console(file=StringIO(), width=90)
    print_pair(pair, console)
    assert isinstance(console.file, StringIO)
    return console.file.getvalue()


def pair(measured: list[Measured], *experiments: str) -> PairDiff:
    one, other = (
        SimpleNamespace(
            run={"experiment": name, "state": "finished", "result": {"problems": []}},
            recording=SimpleNamespace(folder=name),
            end_s=9.0,
        )
        for name in experiments
    )
    first = Difference(1, 20_000_000, "brain", "/brain/all/spikes", "ids[0] 1", "ids[0] 2")
    divergence: Any = Divergence("event x mujoco, seed 1", "event x mujoco, seed 2", 9, first, None)
    return PairDiff(one, other, divergence, [], measured)  # type: ignore[arg-type]


def test_populations_come_before_their_neurons_and_those_farthest_apart_first() -> None:
    rate = next(metric for metric in all_metrics() if metric.name == "rate")
    neurons = [Measured(rate, f"all[{i}]", 10.0, 20.0 + i, 10.0 + i) for i in range(9)]
    groups = [Measured(rate, "near", 50.0, 51.0, 1.0), Measured(rate, "far", 5.0, 1.0, -4.0)]
    words = told(pair([*neurons, *groups], "drive", "drive"))
    rows = [line.split() for line in words[words.index("Firing rate") :].splitlines()]
    assert [row[0] for row in [rows[0][2:], *rows[1:6]]] == [
        "far",
        "near",
        "all[8]",
        "all[7]",
        "all[6]",
        "all[5]",
    ]
    assert rows[6] == ["and", "5", "more"]
    assert "two experiments" not in words


def test_two_experiments_are_called_so() -> None:
    assert told(pair([], "drive", "walk")).startswith("two experiments: drive and walk\n")
