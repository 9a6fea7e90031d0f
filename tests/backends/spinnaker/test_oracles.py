"""The released binaries' own numbers: every bit must be equal, in the files here and in any given one."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_brain_spinnaker.engine import begin_tick, finish_tick
from nrp_brain_spinnaker.host.cells import Grid, load_cells, membrane_constants, synapse_constants
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import exp_accum, exp_fraction, mul, scale, to_accum
from nrp_brain_spinnaker.machine.generator import (
    draw,
    exponential_variate,
    load_sources,
    mean_interval,
    mean_per_tick,
    next_word,
    valid_state,
)
from nrp_brain_spinnaker.machine.synaptic_inputs import Ring, add_entry, read_values
from nrp_brain_spinnaker.models import cell_models

from nrp_core.network.data import Population

OWN = [Path(__file__).parent / "oracles" / name for name in ("spinnaker.json", "spinnaker_rng.json")]
KINDS = {"cases", "units", "kiss64", "exponential_s1615", "slow_source", "fast_source"}


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Give each test the entries of its kind from all files."""
    kind = metafunc.function.__name__.removeprefix("test_").split("_of_")[0]
    given = [path for path in metafunc.config.getoption("oracle") if path.suffix == ".json"]
    entries = [
        pytest.param(entry, id=f"{path.stem}-{kind}-{index}-{entry.get('name', '')}".rstrip("-"))
        for path in [*OWN, *given]
        for index, entry in enumerate(_entries(_read(path), kind))
    ]
    metafunc.parametrize("entry", entries)


def _read(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise pytest.UsageError(f"{path} cannot be read as JSON: {error}") from None
    if isinstance(document, list) and all("populations" in entry for entry in document):
        return {}  # networks on the machine: test_mapping.py checks them
    if not isinstance(document, dict) or not document.keys() & KINDS:
        raise pytest.UsageError(f"{path} has none of {', '.join(sorted(KINDS))}, and no list of networks")
    return document


def _entries(document: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    if kind == "units":
        return [{"name": name, "rows": rows} for name, rows in document.get("units", {}).items()]
    entries: list[dict[str, Any]] = document.get(kind, [])
    return entries


def test_cases_of_single_neurons_agree_in_every_bit(entry: dict[str, Any]) -> None:
    cells, ring = _load(entry)
    seen: dict[str, list[int]] = {"v": [], "gsyn_exc": [], "gsyn_inh": [], "u": [], "ticks": [], "counts": []}
    dropped_bits = 10 if cell_models("released")[entry["model"]].input == kinds.CONDUCTANCE else 0
    for tick in range(entry["n_ticks"]):
        for event in (event for event in entry["events"] if event["tick"] == tick):
            for _ in range(event["count"]):
                add_entry(ring, tick & 1, event["type"], event["raw_weight"])
        begin_tick(cells, ring, tick)
        read_values(cells, 0)
        seen["v"].append(int(cells.state[kinds.V, 0]))
        seen["u"].append(int(cells.state[kinds.U, 0]))
        for receptor, name in enumerate(("gsyn_exc", "gsyn_inh")):
            seen[name].append(int(cells.value[receptor, 0]) >> dropped_bits)
        finish_tick(cells)
        if cells.n_fired[0]:
            seen["ticks"].append(tick)
            seen["counts"].append(int(cells.n_fired[0]))
    for name in ("v", "gsyn_exc", "gsyn_inh", *(["u"] if "u" in entry else [])):
        assert seen[name] == entry[name], name
    assert (seen["ticks"], seen["counts"]) == (entry["spike_ticks"], entry["spikes_in_tick"])
    assert (ring.saturated.sum(), cells.state[kinds.V, 0]) == (entry["saturations"], entry["v_final"])


def _load(case: dict[str, Any]) -> tuple[kinds.Cells, Ring]:
    given = {name: np.array([float(value)]) for name, value in case["params"].items()}
    initial = {name.removesuffix("_init"): given.pop(name) for name in list(given) if name.endswith("_init")}
    population = Population("cell", 1, case["model"], given, initial)
    grid = Grid(round(case["dt_ms"] * 1000), case["n_steps_per_timestep"])
    cells = load_cells([population], np.arange(1), grid, "released")
    cells.populations[0, [kinds.SHIFT_EXC, kinds.SHIFT_INH]] = case["left_shift"]
    return cells, Ring(np.zeros((2, 2), np.uint16), np.zeros(2, np.int64), np.zeros(2, np.int64))


def test_units_of_arithmetic_agree_in_every_bit(entry: dict[str, Any]) -> None:
    operation = {
        "mul_s1615": lambda a, b: (mul(a, b),),
        "scale_u032": lambda a, fraction: (scale(a, fraction),),
        "shr10": lambda a: (a >> 10,),
        "exp": lambda x: (exp_accum(x), exp_fraction(x)),
        "syn_constants": _synapse_constants,
        "lif_constants": _lif_constants,
        "host_to_s1615": lambda value: (int(to_accum(value)),),
    }[entry["name"]]
    n_arguments = operation.__code__.co_argcount
    for row in entry["rows"]:
        assert list(operation(*row[:n_arguments])) == row[n_arguments:], row


def _synapse_constants(dt: float, tau: float, n_steps: int) -> tuple[int, int]:
    decay, init, _ = synapse_constants(kinds.EXPONENTIAL, int(to_accum(dt)) // n_steps, int(to_accum(tau)))
    return decay, init


def _lif_constants(dt: float, tau_m: float, cm: float, tau_refrac: float) -> tuple[int, ...]:
    raw = {
        name: int(to_accum(value))
        for name, value in (("tau_m", tau_m), ("cm", cm), ("tau_refrac", tau_refrac))
    }
    raw |= dict.fromkeys(("v_rest", "v_reset", "v_thresh"), 0)
    constants = membrane_constants(kinds.LIF, int(to_accum(dt)), raw)
    return tuple(constants[row] for row in (kinds.R_MEMBRANE, kinds.EXP_TC, kinds.T_REFRACTORY))


def test_kiss64_of_the_generator_gives_the_same_words(entry: dict[str, Any]) -> None:
    state = valid_state(entry["seed"])
    assert state.tolist() == entry["validated"]
    assert [next_word(state) for _ in entry["out"]] == entry["out"]


def test_exponential_s1615_of_the_generator_gives_the_same_variates(entry: dict[str, Any]) -> None:
    state = np.array(entry["seed"], np.int64)
    assert [exponential_variate(state) for _ in entry["out"]] == entry["out"]


def test_slow_source_of_poisson_spikes_in_the_same_ticks(entry: dict[str, Any]) -> None:
    assert mean_interval(entry["rate_hz"], _step_us(entry)) == entry["mean_isi_ticks"]
    assert _first_spikes(entry, 2000) == entry["first_2000_ticks"]


def test_fast_source_of_poisson_spikes_as_often_in_every_tick(entry: dict[str, Any]) -> None:
    assert mean_per_tick(entry["rate_hz"], _step_us(entry)) == entry["lambda_bits"]
    assert exp_accum(-entry["lambda_bits"]) << 17 == entry["exp_minus_lambda"]
    assert _first_spikes(entry, 500) == entry["first_500_ticks"]


def _step_us(entry: dict[str, Any]) -> int:
    return 1_000_000 // entry["ticks_per_second"]


def _first_spikes(entry: dict, until: int) -> list[list[int]]:
    always = {"rate": entry["rate_hz"], "start": 0.0, "duration": np.inf}
    parameters = {name: np.array([float(value)]) for name, value in always.items()}
    population = Population("source", 1, "SpikeSourcePoisson", parameters)
    sources = load_sources([(population, np.arange(1))], _step_us(entry), lambda _: np.array(entry["seed"]))
    ticks, counts = np.unique(draw(sources, 0, until)[0], return_counts=True)
    return np.stack([ticks, counts], axis=1).tolist()
