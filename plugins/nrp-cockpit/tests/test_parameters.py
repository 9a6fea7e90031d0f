"""Parameters of cells and constants of functions are read and changed while a run goes on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from unittest.mock import Mock

import pytest
from golden import Golden
from nrp_cockpit.session import functions
from nrp_cockpit.session.constants import constants_of
from visitors import Cockpit, RefusedError, Visitor, cockpit

TEXT = """\
# \N{GREEK SMALL LETTER MU}
RATE = 250.0  # Hz of each feeler at contact
CELLS: int = 10
BACK = -1.5e-3
IS_ON = True
TWO = 1 + 1
A = B = 3.0
def f(t):
    INSIDE = 1.0
"""


def test_constants_are_the_numbers_at_the_top_of_a_file() -> None:
    found = [one.number for one in constants_of("steer.py", TEXT)]
    assert [(one.name, one.value, one.whole, one.note) for one in found] == [
        ("RATE", 250.0, False, "Hz of each feeler at contact"), ("CELLS", 10, True, ""),
        ("BACK", -1.5e-3, False, ""),
    ]  # fmt: skip
    assert [(one.low, one.high) for one in found] == [(0.0, 500.0), (0, 20), (-3e-3, 0.0)]
    assert list(constants_of("steer.py", "RATE = ")) == []


@pytest.mark.parametrize(
    ("name", "value", "line"),
    [("RATE", 0.1, "RATE = 0.1  # Hz of each feeler at contact"), ("CELLS", 12.0, "CELLS: int = 12"),
     ("BACK", -2.0, "BACK = -2.0")],
)  # fmt: skip
def test_a_changed_constant_changes_only_its_number(name: str, value: float, line: str) -> None:
    (constant,) = (one for one in constants_of("steer.py", TEXT) if one.number.name == name)
    changed, before = constant.with_value(TEXT, value).splitlines(), TEXT.splitlines()
    assert [new for new, old in zip(changed, before, strict=True) if new != old] == [line]


MODEL = """\
<bibi xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <transferFunction name="turn"><local name="\N{GREEK SMALL LETTER MU}"><body xsi:type="Scale"
    factor = "20"><inner xsi:type="Constant" value='0'/></body></local>
    <device name="wheel"><body xsi:type="Scale" factor="-1e2"><inner xsi:type="Constant" value="0.5"/></body>
    </device></transferFunction>
</bibi>
"""


def test_the_numbers_of_a_model_are_its_gains_and_its_constants() -> None:
    found = list(constants_of("turn.bibi", MODEL))
    assert [(one.number.name, one.number.value, one.number.note) for one in found] == [
        ("turn.\N{GREEK SMALL LETTER MU}", 20.0, "factor"), ("turn.wheel", -100.0, "factor"),
        ("turn.wheel 2", 0.5, "value"),
    ]  # fmt: skip
    text = MODEL
    for place, (value, written) in enumerate([(2.5, "2.5"), (-30.0, "-30.0"), (0.25, "0.25")]):
        text = list(constants_of("turn.bibi", text))[place].with_value(text, value)
        assert f'"{written}"' in text
    assert text == MODEL.replace('"20"', '"2.5"').replace("-1e2", "-30.0").replace("0.5", "0.25")
    assert list(constants_of("turn.bibi", MODEL[:-9])) == []


@pytest.fixture(scope="module")
def opened() -> Iterator[Cockpit]:
    with cockpit(experiment="slalom_pioneer") as opened:
        yield opened


def number(numbers: list[dict[str, Any]], name: str) -> dict[str, Any]:
    (found,) = (one for one in numbers if one["name"] == name)
    return found


def of_cells(visitor: Visitor, name: str, **cell: Any) -> dict[str, Any]:
    populations = visitor.call("parameters", **cell)["populations"]
    return number(populations[-1]["numbers"], name)


def of_file(visitor: Visitor, name: str) -> dict[str, Any]:
    (file,) = visitor.call("parameters")["functions"]
    return number(file["numbers"], name)


def test_a_parameter_acts_and_its_value_is_true_after_going_back(visitor: Visitor) -> None:
    usual = of_cells(visitor, "v_thresh")
    assert (usual["value"], usual["note"], usual["low"], usual["high"]) == (-50.0, "mV", -70.0, -30.0)
    visitor.call("step", n=10)
    spikes = visitor.call("run_to", t_s=0.4)
    visitor.status(state="paused", t_s=0.4)
    visitor.call("parameters/cells", population="wheels", name="v_thresh", value=1e6)
    assert of_cells(visitor, "v_thresh")["value"] == 1e6
    visitor.call("seek", t_s=0.2)
    assert of_cells(visitor, "v_thresh")["value"] == -50.0
    visitor.call("seek", t_s=0.4)
    assert of_cells(visitor, "v_thresh")["value"] == 1e6
    visitor.call("reset", what="all")
    assert of_cells(visitor, "v_thresh")["value"] == -50.0
    assert spikes == {}


def test_one_cell_can_differ_and_impossible_values_are_refused(visitor: Visitor, golden: Golden) -> None:
    assert of_cells(visitor, "i_offset")["value"] is None  # they differ
    cell = {"population": "wheels", "index": 3}
    visitor.call("parameters/cells", name="i_offset", value=0.5, **cell)
    assert of_cells(visitor, "i_offset", **cell)["value"] == 0.5
    assert of_cells(visitor, "i_offset", population="wheels", index=4)["value"] != 0.5
    with golden.raises(RefusedError):
        visitor.call("parameters/cells", population="wheels", name="tau_m", value=-1.0)
    with pytest.raises(RefusedError, match="'wheels'"):
        visitor.call("parameters/cells", population="wheel", name="tau_m", value=1.0)
    with pytest.raises(RefusedError, match=r"19.*20"):
        visitor.call("parameters", population="wheels", index=20)


def test_weights_change_with_a_mark_until_the_run_goes_back(opened: Cockpit, visitor: Visitor) -> None:
    projection = opened.run.brain.network.projections[0].label

    def mean() -> float:
        return float(visitor.call("weights", projection=projection)["summary"][1])

    def edits() -> list[tuple[float, str]]:
        return [(each["t_s"], each["name"]) for each in visitor.last("timeline")["edits"]]

    usual = mean()
    visitor.call("step", n=10)
    visitor.call("weights/scale", projection=projection, factor=2.0)
    assert mean() == 2 * usual
    visitor.call("step", n=5)
    visitor.call("weights/set", projection=projection, weight=0.0)
    visitor.call("weights/set", projection=projection, weight=usual / 4)
    assert mean() == usual / 4
    marks = [
        (0.2, f"weights of {projection} \N{MULTIPLICATION SIGN} 2"),
        (0.3, f"weights of {projection} = {usual / 4:g}"),
    ]
    visitor.until(lambda: edits() == marks)
    for t_s, factor in [(0.28, 2.0), (0.1, 1.0), (0.2, 2.0), (0.3, 0.25)]:
        visitor.call("seek", t_s=t_s)
        assert mean() == factor * usual
    visitor.call("seek", t_s=0.24)
    visitor.call("step")
    visitor.until(lambda: edits() == marks[:1])
    visitor.call("reset", what="all")
    visitor.until(lambda: edits() == [])
    assert mean() == usual


def test_a_constant_is_an_edit_of_its_file_that_can_be_reverted(
    visitor: Visitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    (file,) = (each["file"] for each in visitor.call("parameters")["functions"])
    assert of_file(visitor, "RATE")["value"] == 250.0
    assert visitor.call("parameters/function", file=file, name="RATE", value=100.0)["applied"]
    assert of_file(visitor, "RATE")["value"] == 100.0
    sources = visitor.until(lambda: [
        each["source"] for each in visitor.last("functions")["files"]
        if each["path"] == file and "RATE = 100.0" in each["source"]
    ])  # fmt: skip
    assert "RATE = 100.0  # Hz of each feeler at contact" in sources[0]
    checks = Mock(return_value=[])
    monkeypatch.setattr(functions, "validate", checks)
    assert visitor.call("parameters/function", file=file, name="RATE", value=90.0)["applied"]
    assert not checks.called  # it would stop the run for half a second
    monkeypatch.undo()
    assert not any("RATE" in found["summary"] for found in visitor.call("functions/recheck")["findings"])
    with pytest.raises(RefusedError, match="'RATE'"):
        visitor.call("parameters/function", file=file, name="RATES", value=1.0)
    visitor.call("functions/revert")
    assert of_file(visitor, "RATE")["value"] == 250.0


def test_a_run_begins_again_with_another_seed_and_its_edited_functions(visitor: Visitor) -> None:
    (file,) = (each["file"] for each in visitor.call("parameters")["functions"])
    visitor.call("parameters/function", file=file, name="RATE", value=100.0)
    visitor.call("step", n=5)
    visitor.subscribe("/cockpit/experiment")
    visitor.call("reseed", seed=7)
    visitor.status(state="paused", t_s=0.0)
    assert visitor.until(lambda: visitor.last("experiment")["seed"] == 7)
    assert of_file(visitor, "RATE")["value"] == 100.0
    visitor.call("reseed", seed=1)


def test_functions_are_checked_and_changed_also_when_another_thread_parses(
    visitor: Visitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    (file,) = (each["file"] for each in visitor.call("parameters")["functions"])
    for name in ("validate", "load_function_file"):
        failing, real = iter([True]), getattr(functions, name)

        def call(*arguments: Any, failing: Any = failing, real: Any = real) -> Any:
            if next(failing, False):
                raise SystemError("AST constructor recursion depth mismatch (before=120, after=61)")
            return real(*arguments)

        monkeypatch.setattr(functions, name, call)
    text = opened_text(visitor, file)
    assert visitor.call("functions/apply", files={file: text + "\n"})["applied"]
    visitor.call("functions/revert")


def opened_text(visitor: Visitor, file: str) -> str:
    """The text of a file of functions."""
    visitor.until(lambda: visitor.last("functions"))
    (text,) = (each["source"] for each in visitor.last("functions")["files"] if each["path"] == file)
    return str(text)
