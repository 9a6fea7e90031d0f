"""Mistakes in files of NESTML are one error, with its line where there is one."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from nrp_nestml.cell import cell_of
from nrp_nestml.errors import NestmlError

MODEL = """model lif_neuron:
    state:
        V_m mV = E_L
        refr_t ms = 0 ms
        I_syn pA = 0 pA

    equations:
        I_syn' = -I_syn / tau_syn
        V_m' = -(V_m - E_L) / tau_m + (I_syn + I_e) / C_m
        refr_t' = -1

    parameters:
        C_m pF = 250 pF
        tau_m ms = 10 ms
        tau_syn ms = 2 ms
        refr_T ms = 2 ms
        E_L mV = -70 mV
        V_th mV = -55 mV
        I_e pA = 0 pA

    internals:
        unit_psc pA = 1 pA

    input:
        spikes <- excitatory spike
        others <- inhibitory spike

    output:
        spike

    update:
        if refr_t > 0 ms:
            integrate_odes(I_syn, refr_t)
        else:
            integrate_odes(I_syn, V_m)

    onReceive(spikes):
        I_syn += unit_psc * spikes * 1 s

    onCondition(refr_t <= 0 ms and V_m >= V_th):
        refr_t = refr_T
        V_m = E_L
        emit_spike()
"""
MISTAKES = {
    "colon": ("    state:", "    state", "^line 3: .*missing ':'"),
    "letter of a unit": ("250 pF", "250 pf", '^line 13: .*"pf"'),
    "comparison": ("refr_t = refr_T", "refr_t == refr_T", "^line 41: .*'refr_t =='"),
    "number": ("tau_m ms = 10 ms", "tau_m ms = 10", 'line 14: .*Expected: "ms", got: "integer"'),
    "sum": (" / C_m", "", "line 9: Operation mV / ms .*pA is not defined"),
    "pulse": (" * 1 s", "", 'line 38: .*Expected: "pA", got: "pA / s"'),
    "second": ("* 1 s", "* 1 ms", "line 38: a spike is a pulse in 1/s: it is multiplied by 1 s, not by 1 ms"),
    "time": (
        "tau_m ms = 10 ms",
        "tau_m mV = 10 mV",
        "line 9: the equation of 'V_m' adds a number without a u",
    ),
    "reset": ("V_m = E_L\n        emit", "V_m = refr_T\n        emit", 'line 42: .*"mV", got: "ms"'),
    "parameter": ("tau_syn ms", "tau_m ms", "redeclared"),
    "two equations": ("refr_t' = -1", "refr_t' = -1\n        refr_t' = -1", "line 11: 'refr_t' has two equa"),
    "unknown": ("integrate_odes(I_syn, V_m)", "integrate_odes(I_sin, V_m)", 'line 35: .*"I_sin"'),
    "no output": ("    output:\n        spike\n", "", "output block not defined"),
    "not integrated": ("(I_syn, V_m)", "(I_syn)", "no integrate_odes.. integrates 'V_m'"),
    "waits only": ("(I_syn, V_m)", "(V_m)", "'I_syn' outside of the refractory period"),
    "endless": ("(I_syn, refr_t)", "(I_syn)", "integrates 'refr_t', so its period would not end"),
    "grows": ("refr_t' = -1", "refr_t' = 1", "so its equation is refr_t' = -1"),
    "no equation": ("        refr_t' = -1\n", "", "so its equation is refr_t' = -1"),
    "begins": ("refr_t ms = 0 ms", "refr_t ms = 9 ms", "'refr_t' is 9 at the start"),
    "port": (
        "onReceive(spikes)",
        "onReceive(spiks)",
        "line 38: .*no spike port 'spiks'; there are: others, sp",
    ),
    "two ports": ("<- inhibitory", "<- excitatory", "line 26: it has more than one excitatory port"),
    "other port": ("unit_psc * spikes", "unit_psc * others", "line 38: .*does not depend on 'spikes'"),
    "no threshold": (" and V_m >= V_th", "", "line 40: a spike needs a condition besides 'refr_t <= 0 ms'"),
}


def written(folder: Path, text: str) -> Path:
    file = folder / "lif.nestml"
    file.write_text(text)
    return file


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_error(name: str, tmp_path: Path) -> None:
    right, wrong, message = MISTAKES[name]
    assert right in MODEL
    with pytest.raises(NestmlError, match=message) as caught:
        cell_of(written(tmp_path, MODEL.replace(right, wrong, 1)))
    assert "\n" not in str(caught.value)


def test_units_that_are_factors_by_themselves_are_numbers(tmp_path: Path) -> None:
    """NESTML 8 and files of its repository have them; NESTML 9 refuses them."""
    lone = MODEL.replace("refr_t' = -1", "refr_t' = -1e3 * ms/s")
    assert cell_of(written(tmp_path, lone)) == cell_of(written(tmp_path, MODEL))
    wrong = written(tmp_path, MODEL.replace("refr_t' = -1", "refr_t' = -2e3 * ms/s"))
    with pytest.raises(NestmlError, match="refr_t' = -1"):
        cell_of(wrong)


def test_the_program_ends_with_an_exit_code(tmp_path: Path) -> None:
    program = [sys.executable, "-m", "nrp_nestml"]
    wrong = written(tmp_path, MODEL.replace("refr_t' = -1", "refr_t' = 1"))
    done = subprocess.run([*program, wrong], capture_output=True, text=True, check=False)
    assert (done.returncode, list(json.loads(done.stdout))) == (1, ["error"])
    assert "so its equation is refr_t' = -1" in done.stderr


def test_two_files_of_one_name_are_refused(tmp_path: Path) -> None:
    program = [
        sys.executable,
        "-m",
        "nrp_nestml",
        tmp_path / "a" / "lif.nestml",
        tmp_path / "b" / "lif.nestml",
    ]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert "several files have the name 'lif'" in done.stderr


def test_a_file_without_a_mistake_is_a_cell(tmp_path: Path) -> None:
    cell = cell_of(written(tmp_path, MODEL))
    assert "dV_m/dt" in cell["equations"]
    assert list(cell["receptors"]) == ["excitatory"]
