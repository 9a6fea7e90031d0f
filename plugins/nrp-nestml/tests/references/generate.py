"""Writes the references of this folder: neurons of NESTML, run by the Python that NESTML generates from them.

    python generate.py                        # all of them, some minutes; it needs nestml and scipy
    python generate.py izhikevich_neuron

NESTML's target ``python_standalone`` writes a class for a model; its equations, thresholds and what happens
at spikes are NESTML's. Only the lengths of its steps are chosen here. ``grid``: each is 0.1 ms, and NESTML's
exact propagators advance the cell. ``crossing``: a step in which the cell fires is shortened until its end is
the crossing, and one ends where the refractory period does, so that spikes do not depend on the steps.
``peak``: 0.005 ms above -20 mV, for neurons that fire where the voltage begins to fall. In the last two all
equations are integrated together, with a relative error of 1e-9.
"""

from __future__ import annotations

import copy
import json
import re
import shutil
import sys
import tempfile
from functools import partial
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pynestml
import scipy.integrate
from pynestml.frontend.pynestml_frontend import generate_python_standalone_target

HERE = Path(__file__).parent
MODELS = Path(sys.prefix) / "models/neurons"
TEMPLATES = Path(pynestml.__file__).parent / "codegeneration/resources_python_standalone/point_neuron"
STEP_MS, SHORT_MS, END_MS = 0.1, 0.005, 60.0
FUNCTION = """{%- macro FunctionDeclaration(function, prefix) %}
  def {{ function.get_name() }}(self{% for one in function.get_parameters() %},
 {{ one.get_name() }}{% endfor %})
{%- endmacro -%}"""
"""NESTML 9.0 writes the first line of a function in C++ here; this is the same in Python."""
MENDS = (
    ("@NEURON_NAME@.py", "from math import *", "from math import *\nfrom math import log as ln"),
    (
        "directives_py/GSLDifferentiationFunction",
        "if variable_name in",
        "if variable_name.removesuffix('__d') in",
    ),
)
"""NESTML 9.0 does not translate ln, and leaves x' constant where integrate_odes(x) names an x with an x''."""

UNITS = {"hh_moto_5ht_neuron": ("0.01 s**-1", "0.00001 ms**-1")}
"""The same rate in another unit: NESTML's equations drop the factor of a unit with a power, so that there
0.01 s**-1 is 0.01 in a millisecond."""


class Case(NamedTuple):
    """A model and its input.

    Args:
        model: its name.
        steps: ``grid``, ``crossing`` or ``peak``.
        current_pa: of the first and third cell, from 2 ms to 50 ms.
        ports: weight and number of spikes of each spike port, of the second and third cell.
        other: parameters of the third cell.
    """

    model: str
    steps: str
    current_pa: float
    ports: dict[str, tuple[float, int]]
    other: dict[str, float]


def two(excitatory: float, inhibitory: float, n: int = 30) -> dict[str, tuple[float, int]]:
    """Return the usual ports."""
    return {"exc_spikes": (excitatory, n), "inh_spikes": (inhibitory, n // 3)}


FOUR = {"AMPA": (100.0, 20), "NMDA": (40.0, 10), "GABA_A": (10.0, 10), "GABA_B": (100.0, 5)}
"""Ports of neurons with several receptors."""
CASES = (
    Case("iaf_psc_exp_neuron", "grid", 600.0, two(900.0, 300.0), {"tau_m": 15.0}),
    Case("iaf_psc_alpha_neuron", "grid", 600.0, two(400.0, 100.0), {"tau_m": 15.0}),
    Case("iaf_psc_delta_neuron", "grid", 600.0, {"spikes": (6.0, 90)}, {"tau_m": 15.0}),
    Case("iaf_psc_delta_fixed_timestep_neuron", "grid", 600.0, {"spikes": (6.0, 150)}, {"tau_m": 15.0}),
    Case("mat2_psc_exp_neuron", "grid", 600.0, two(800.0, 100.0), {"tau_m": 8.0}),
    Case("iaf_cond_exp_neuron", "crossing", 450.0, two(100.0, 5.0), {"g_L": 14.0}),
    Case("iaf_cond_alpha_neuron", "crossing", 450.0, two(80.0, 5.0), {"g_L": 14.0}),
    Case("iaf_cond_beta_neuron", "crossing", 450.0, two(12.0, 5.0), {"g_L": 14.0}),
    Case("iaf_cond_exp_sfa_rr_neuron", "crossing", 800.0, two(20.0, 4.0), {"q_sfa": 20.0}),
    Case("iaf_chxk_2008_neuron", "crossing", 2500.0, two(60.0, 20.0), {"C_m": 800.0}),
    Case("izhikevich_neuron", "crossing", 12.0, {"spikes": (8.0, 30)}, {"a": 0.03}),
    Case("izhikevich_psc_alpha_neuron", "crossing", 1500.0, two(4000.0, 300.0), {"k": 7.0}),
    Case("aeif_cond_alpha_neuron", "crossing", 900.0, two(80.0, 5.0), {"a": 6.0}),
    Case("aeif_cond_exp_neuron", "crossing", 900.0, two(160.0, 10.0), {"a": 6.0}),
    Case("aeif_psc_exp_neuron", "crossing", 900.0, two(16000.0, 900.0), {"a": 6.0}),
    Case("aeif_psc_alpha_neuron", "crossing", 900.0, two(6000.0, 300.0), {"a": 6.0}),
    Case("aeif_cond_alpha_alt_neuron", "crossing", 900.0, two(80.0, 5.0), {"a": 6.0}),
    Case("hh_psc_alpha_neuron", "peak", 800.0, two(3000.0, 200.0), {"C_m": 120.0}),
    Case("hh_cond_exp_traub_neuron", "peak", 600.0, two(8.0, 3.0), {"C_m": 180.0}),
    Case("hh_moto_5ht_neuron", "peak", 800.0, two(3000.0, 200.0), {"C_m": 180.0}),
    Case("wb_cond_exp_neuron", "peak", 300.0, two(60.0, 3.0), {"C_m": 120.0}),
    Case("traub_psc_alpha_neuron", "peak", 400.0, two(3000.0, 200.0), {"C_m": 120.0}),
    Case("traub_cond_multisyn_neuron", "peak", 400.0, FOUR, {"C_m": 120.0}),
    Case("wb_cond_multisyn_neuron", "peak", 300.0, FOUR, {"C_m": 120.0}),
    Case("terub_gpe_neuron", "peak", 20.0, two(0.3, 0.1), {"g_L": 0.2}),
    Case("terub_stn_neuron", "peak", 40.0, two(0.5, 0.5), {"g_L": 2.0}),
)


def _model(name: str, folder: Path) -> Path:
    """Return the file of a model; where NESTML drops a unit, a copy with another one."""
    path = MODELS / f"{name}.nestml"
    if name not in UNITS:
        return path
    written, same = UNITS[name]
    text = path.read_text()
    assert written in text
    (folder / path.name).write_text(text.replace(written, same))
    return folder / path.name


def generated(case: Case, folder: Path) -> Any:
    """Return the class that NESTML writes for a model."""
    templates = folder / "templates"
    if not templates.exists():
        shutil.copytree(TEMPLATES, templates)
        (templates / "directives_py/FunctionDeclaration.jinja2").write_text(FUNCTION)
        for name, wrong, right in MENDS:
            text = (templates / f"{name}.jinja2").read_text()
            assert wrong in text
            (templates / f"{name}.jinja2").write_text(text.replace(wrong, right))
    options: dict[str, Any] = {"solver": "analytic" if case.steps == "grid" else "numeric"}
    options["templates"] = {
        "path": str(templates),
        "model_templates": {"neuron": ["@NEURON_NAME@.py.jinja2"], "synapse": ["@SYNAPSE_NAME@.py.jinja2"]},
        "module_templates": ["neuron.py.jinja2", "utils.py.jinja2"],
    }
    if case.steps != "grid":
        options["simplify_expression"] = "expr"  # nothing is solved, and simpler forms take minutes
    generate_python_standalone_target(
        [str(_model(case.model, folder))],
        target_path=str(folder / f"of_{case.model}"), logging_level="ERROR", codegen_opts=options,
    )  # fmt: skip
    module = import_module(f"of_{case.model}.{case.model}")
    kind = getattr(module, f"Neuron_{case.model}")
    for name in re.findall(
        r"^    function (\w+)", (MODELS / f"{case.model}.nestml").read_text(), re.MULTILINE
    ):
        setattr(module, name, partial(getattr(kind, name), None))  # as they call each other
    return kind


class Run:
    """One cell in the course of time; arrivals are steps of the grid."""

    def __init__(self, kind: Any, case: Case, parameters: dict[str, float]) -> None:
        self.cell, self.case = kind(STEP_MS), case
        self.cell.__init__(STEP_MS)  # internals may need the voltage, which the first time is set after them
        for name, value in parameters.items():
            getattr(self.cell.P_, name)  # a name that is wrong is an error
            setattr(self.cell.P_, name, value)
        self.cell.recompute_internal_variables(STEP_MS)
        self.fired: list[float] = []

    def value(self, name: str) -> float:
        """Return a variable."""
        places = getattr(self.cell.S_, "ode_state_variable_name_to_index", {})
        in_ode = name in places
        return float(self.cell.S_.ode_state[places[name]] if in_ode else getattr(self.cell.S_, name))

    def advance(self, k: int, arriving: dict[str, float], current_pa: float) -> None:
        """Advance by the step of the grid that ends at ``k``; spikes arrive at its end."""
        self.cell.B_.I_stim = current_pa
        now, end = (k - 1) * STEP_MS, k * STEP_MS
        while end - now > 1e-12:
            length = self._length(end - now)
            last = arriving if length == end - now else {}
            if self._fires(length):
                length, last = self._crossing(length), {}
            self._step(length, last)
            now = end if length == end - now else now + length
            if self.cell.pop_emitted_spikes():
                self.fired.append(now)

    def _length(self, left: float) -> float:
        if self.case.steps == "grid":
            return left
        if self.case.steps == "peak":
            return min(left, SHORT_MS) if self.value("V_m") > -20.0 and left > 1.5 * SHORT_MS else left
        waits = self.value("refr_t") if hasattr(self.cell.P_, "refr_T") else 0.0
        return min(left, waits + 1e-13) if waits > 0.0 else left

    def _step(self, length: float, arriving: dict[str, float]) -> None:
        for port, weight in arriving.items():
            self.cell.handle(length, weight, port)
        self.cell.step(0.0, length)  # no equation has the time; near 0 it has the most digits

    def _fires(self, length: float) -> bool:
        """Return whether the cell would fire in a step, which is not made."""
        if self.case.steps != "crossing":
            return False
        before = copy.deepcopy(self.cell.S_)
        try:
            self._step(length, {})
        except AssertionError:  # the integration ends in an upstroke that is infinitely steep
            return True
        finally:
            self.cell.S_ = before
        return bool(self.cell.pop_emitted_spikes())

    def _crossing(self, length: float) -> float:
        shorter, longer = 0.0, length
        while longer - shorter > 1e-12:
            middle = 0.5 * (shorter + longer)
            shorter, longer = (shorter, middle) if self._fires(middle) else (middle, longer)
        return longer


def reference(case: Case, kind: Any) -> dict[str, Any]:
    """Return what the three cells of a case receive and do."""
    rng = np.random.default_rng(4)
    trains = {
        port: np.sort(rng.choice(np.arange(20, round(END_MS / STEP_MS)), n, replace=False)).tolist()
        for port, (_, n) in case.ports.items()
    }
    cells = []
    for parameters, has_current, has_spikes in (
        ({}, True, False),
        ({}, False, True),
        (case.other, True, True),
    ):
        run, values = Run(kind, case, parameters), []
        arrivals = trains if has_spikes else {}
        for k in range(1, round(END_MS / STEP_MS) + 1):
            arriving = {port: case.ports[port][0] for port, train in arrivals.items() if k in train}
            run.advance(k, arriving, case.current_pa if has_current and 20 < k <= 500 else 0.0)
            if k % 5 == 0:
                values.append(round(run.value("V_m"), 9))
        cells.append({
            "parameters": parameters,
            "current": {"pa": case.current_pa if has_current else 0.0, "start_ms": 2.0, "stop_ms": 50.0},
            "spikes": {
                port: {"weight": case.ports[port][0], "steps": train} for port, train in arrivals.items()
            },
            "fired_ms": [round(time, 6) for time in run.fired], "values": values,
        })  # fmt: skip
        print(case.model, len(run.fired), "spikes;", min(values), "to", max(values), flush=True)
    return {
        "model": case.model, "program": f"python_standalone of NESTML {version('nestml')}",
        "steps": case.steps, "every_ms": 0.5, "cells": cells,
    }  # fmt: skip


def main() -> None:
    """Write the references that are named, or all."""
    exact = partial(scipy.integrate.solve_ivp, rtol=1e-9, atol=1e-10)
    scipy.integrate.solve_ivp = exact
    with tempfile.TemporaryDirectory() as folder:
        sys.path.insert(0, folder)
        for case in CASES:
            if sys.argv[1:] and case.model not in sys.argv[1:]:
                continue
            found = reference(case, generated(case, Path(folder)))
            (HERE / f"{case.model}.json").write_text(json.dumps(found) + "\n")


if __name__ == "__main__":
    main()
