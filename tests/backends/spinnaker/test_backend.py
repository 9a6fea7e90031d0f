"""The entry point: what it declares, what it costs to import, and that any machine computes the same."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from golden import Golden
from nrp_brain_spinnaker import SpinnakerBackend, SpinnakerOptions
from pydantic import ValidationError

from nrp_core.clock import StepPlan
from nrp_core.errors import TimestepError
from nrp_core.simulation import Determinism


def test_importing_and_reading_capabilities_does_not_load_a_compiler() -> None:
    code = (
        "import sys; from nrp_brain_spinnaker import SpinnakerBackend as B; b = B(); "
        "b.capabilities(b.options()); sys.exit('numba' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=300).returncode == 0


def test_extensions_are_marked() -> None:
    has = SpinnakerBackend().capabilities(SpinnakerOptions())
    assert has.determinism is Determinism.BITWISE
    added = {"IF_cond_alpha", "EIF_cond_exp_isfa_ista", "EIF_cond_alpha_isfa_ista", "HH_cond_exp"}
    assert has.extensions == added | {"tsodyks_markram"}
    assert has.extensions <= has.cells | has.synapses
    assert {"IF_curr_exp", "IZK_cond_exp", "Izhikevich"} <= has.cells - has.extensions


def test_the_loop_refuses_a_period_off_the_grid(golden: Golden) -> None:
    has = SpinnakerBackend().capabilities(SpinnakerOptions(timestep="0.3 ms"))
    with golden.raises(TimestepError, match=r"0\.3"):
        StepPlan(20_000_000, has.resolution_ns)


@pytest.mark.parametrize(
    "option",
    [
        {"timestep": "0 ms"},
        {"timestep": "1500 ns"},
        {"timestep": 1},
        {"semantics": "pyn"},
        {"weights": "both"},
        {"neurons_per_core": 257},
        {"time_step": "1 ms"},
    ],
)
def test_an_impossible_option_is_refused(option: dict, golden: Golden) -> None:
    with golden.raises(ValidationError):
        SpinnakerOptions.model_validate(option)


@pytest.mark.heavy
@pytest.mark.slow
def test_without_a_compiler_every_bit_is_the_same() -> None:
    script = Path(__file__).parent / "every_kernel.py"
    digests = [
        subprocess.run(
            [sys.executable, "-W", "error", script], env=os.environ | {"NUMBA_DISABLE_JIT": disabled},
            check=True, capture_output=True, text=True, timeout=300,
        ).stdout
        for disabled in ("0", "1")
    ]  # fmt: skip
    assert digests[0] == digests[1]
    assert "9 cell types fired" in digests[0]
