"""The lazy grid gives the spikes of the plain grid, whatever the network and whatever is changed."""

from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_brain_event import EventBackend, EventOptions
from nrp_brain_event.grid.lazy_brain import LazyBrain
from nrp_brain_event.options import lazy_grid_obstacle
from nrp_conformance.brain import kit
from nrp_conformance.brain.capability import RULE
from nrp_conformance.brain.kit import SAMPLES
from pydantic import ValidationError

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.devices.sources import PoissonSource
from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds
from nrp_core.errors import CapabilityError
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.equations.model import CELL_TYPE
from nrp_core.network.synapses import STATIC, STDP, TSODYKS_MARKRAM

_UNITS = {
    "v_rest": "mV",
    "v_reset": "mV",
    "v_thresh": "mV",
    "tau_m": "ms",
    "cm": "nF",
    "tau_refrac": "ms",
    "i_offset": "nA",
}
_INTO_MEMBRANE = "dv/dt = (v_rest - v)/tau_m + (i_offset + {})/cm : mV (unless refractory)\n"
OWN = {
    "adapting": CellEquations(
        _INTO_MEMBRANE.format("g - w") + """
        dg/dt = -g/(5*ms) : nA (unless refractory)
        dw/dt = (0.02*uS*(v - v_rest) - w)/(30*ms) : nA
        """,
        "v > v_thresh", "v = v_reset; g = 0*nA; w += 0.2*nA", "tau_refrac",
        {"excitatory": "g", "inhibitory": "g (also refractory)"}, _UNITS,
    ),
    "resonating": CellEquations(  # with complex eigenvalues: it also fires after inhibition
        _INTO_MEMBRANE.format("g - u") + """
        du/dt = (0.5*uS*(v - v_rest) - u)/(10*ms) : nA
        dg/dt = (h - g)/(2*ms) : nA
        dh/dt = -h/(2*ms) : nA
        limit = v_thresh + 0.1*Mohm*u : mV
        """,
        "v >= limit and v > v_rest", "v = v_reset - min(v - limit, 2*mV)", "tau_refrac",
        {"excitatory": "h += weight*2.7", "inhibitory": "v += weight*4*Mohm (also refractory)"}, _UNITS,
    ),
}  # fmt: skip
"""Cells whose equations are linear."""
LIKE_THEM = SAMPLES["IF_curr_exp"]
KINDS = ("IF_curr_exp", "IF_curr_alpha", "IF_curr_delta", "IF_curr_exp_frozen", *OWN)
STATES: dict[str, dict[str, Any]] = {
    STATIC: {},
    TSODYKS_MARKRAM: {"U": 0.4, "tau_rec": 50.0, "tau_facil": 5.0},
    STDP: {
        "A_plus": 0.1, "A_minus": 0.12, "tau_plus": 20.0, "tau_minus": 15.0, "w_min": 0.0,
        "dendritic_delay_fraction": 1.0,
    },
}  # fmt: skip


def opened(network: Network, lazy: str, resolution: str = "0.1 ms") -> Brain:
    options = EventOptions.model_validate({"resolution": resolution, "lazy": lazy})
    return EventBackend().open(network, seed=7, options=options)


def sample_of(kind: str) -> kit.Sample:
    return SAMPLES.get(kind, LIKE_THEM)


def cells_of(kind: str, label: str, size: int, **parameters: Any) -> Population:
    made = kit.cells(sample_of(kind), label, size, **parameters)
    if kind not in OWN:
        return made
    values = {name: made.parameters[name] for name in _UNITS}
    at_start = {name: np.zeros(size) for name in OWN[kind].model.variables} | {"v": values["v_rest"]}
    return Population(label, size, CELL_TYPE, values, at_start, equations=OWN[kind])


def random_network(seed: int, kinds: list[str]) -> Network:
    """Return cells of which some fire by themselves, connected at random, with sources and noise."""
    rng = np.random.default_rng(seed)
    sizes = rng.integers(5, 40, len(kinds)).tolist()
    made: list[Population | Projection] = [
        kit.spikes("in", *(np.unique(rng.uniform(0.0, 40.0, 8)) for _ in range(4))),
        kit.poisson("noise", 20, 150.0),
    ]
    labels = [f"{k} {kind}" for k, kind in enumerate(kinds)]
    for label, kind, size in zip(labels, kinds, sizes, strict=True):
        drives = sample_of(kind).current_na * np.maximum(rng.uniform(-1.0, 2.0, size), 0.0)
        alike = (
            {"tau_syn_I": 2.0}
            if rng.random() < 0.5 and kind.startswith("IF") and kind != "IF_curr_delta"
            else {}
        )
        periods = rng.choice([0.0, 0.2, 2.0]) if rng.random() < 0.7 else rng.choice([0.0, 0.1, 1.3], size)
        made.append(cells_of(kind, label, size, i_offset=drives, tau_refrac=periods, **alike))
    for pre, n_pre in [("in", 4), ("noise", 20), *zip(labels, sizes, strict=True)]:
        for post, n_post in zip(labels, sizes, strict=True):
            for receptor, sign in (("excitatory", 1.0), ("inhibitory", -0.5)):
                kind = str(rng.choice([STATIC, STATIC, TSODYKS_MARKRAM, STDP]))
                n, strong = 4 * n_post, sample_of(post.split(" ", 1)[1]).strong
                weight = rng.uniform(0.0, 0.3 * strong, n) if rng.random() < 0.8 else np.full(n, 0.1 * strong)
                states = dict(STATES[kind]) | ({"w_max": 0.4 * strong} if kind == STDP else {})
                made.append(
                    Projection(
                        f"{pre} to {post} {receptor}", pre, post, receptor,
                        rng.integers(0, n_pre, n, np.int32), rng.integers(0, n_post, n, np.int32),
                        sign * weight, 0.1 + rng.choice([0.0, 4.0]) * rng.random(n),
                        kind, {name: np.full(n, value) for name, value in states.items()},
                        RULE if kind == STDP else {},
                    )
                )  # fmt: skip
    return kit.network(*made)


def course(network: Network, lazy: str, resolution: str, *, changes: bool) -> list[Any]:
    """Return spikes, voltages and samples of three legs, each from a snapshot of the one before."""
    seen: list[Any] = []
    snapshot = None
    cells = [label for label in network.populations if label[0].isdigit()]
    first = network.ids_of(cells[0])
    everyone = np.concatenate([network.ids_of(label) for label in cells])
    strong = sample_of(cells[0].split(" ", 1)[1]).strong
    for leg, t_ms in enumerate((12.0, 25.0, 40.0)):
        with opened(network, lazy, resolution) as brain:
            assert isinstance(brain, LazyBrain) == (lazy == "always")
            recorder = brain.add_sink(SpikeRecorder(), np.arange(network.size), name="all")
            brain.add_source(PoissonSource(rate=300.0, weight=0.2 * strong, delay=0.5), first, name="drive")
            if snapshot is not None:
                brain.restore(snapshot)
            if leg == 1 and changes:
                label = f"{cells[0]} to {cells[0]} excitatory"
                brain.set_weights(label, 0.7 * brain.read_weights(label))
                brain.set_parameters(first[::2], {"i_offset": 0.3, "tau_refrac": 1.0})
            if leg == 2 and changes:
                brain.set_parameters(first, {"tau_m": 7.0, "v_thresh": -51.0})
                late = PoissonSource(rate=200.0, weight=0.5 * strong, delay=0.2)
                brain.add_source(late, everyone, name="late")
            brain.run_until(from_milliseconds(t_ms - 1.0))
            seen.append(brain.read_state("v", everyone))
            brain.run_until(from_milliseconds(t_ms))
            seen.append(brain.read_state("v", everyone))
            seen += [brain.read_weights(projection.label) for projection in network.projections]
            spikes = recorder.spikes()
            seen.append(np.stack([spikes.times_ms, spikes.neurons]))
            snapshot = brain.snapshot()
    return seen


def assert_alike(found: list[Any], expected: list[Any]) -> None:
    for mine, theirs in zip(found, expected, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("among", [KINDS[:4], pytest.param(KINDS, marks=pytest.mark.heavy)], ids=len)
@given(
    data=st.data(), seed=st.integers(0, 2**32 - 1), resolution=st.sampled_from(["0.1 ms", "0.5 ms"]),
    changes=st.booleans(),
)  # fmt: skip
@settings(max_examples=3, deadline=None)
def test_the_lazy_grid_gives_the_spikes_of_the_plain_grid(
    among: tuple[str, ...], data: st.DataObject, seed: int, resolution: str, changes: bool
) -> None:
    """With plasticity of both kinds, late devices, changed parameters and weights, and snapshots; kernels of
    equations take long to compile.
    """
    network = random_network(seed, data.draw(st.lists(st.sampled_from(among), min_size=1, max_size=3)))
    plain = course(network, "never", resolution, changes=changes)
    assert plain[-1].shape[1] > 0
    assert_alike(course(network, "always", resolution, changes=changes), plain)


def silent(size: int, **parameters: float) -> Population:
    return kit.cells(SAMPLES["IF_curr_exp"], "n", size, **parameters)


def fired(brain: Brain, until_ms: float) -> list[tuple[float, int]]:
    recorder = brain.add_sink(SpikeRecorder(), np.arange(brain.network.size), name="all")
    brain.run_until(from_milliseconds(until_ms))
    spikes = recorder.spikes()
    return list(zip(spikes.times_ms.tolist(), spikes.neurons.tolist(), strict=True))


def test_a_bound_that_is_too_low_would_lose_spikes() -> None:
    network = kit.network(kit.spikes("s", [5.0]), silent(1), kit.connect("s", "n", 5.0, 1.0))
    with (
        opened(network, "always") as right,
        opened(network, "always") as wrong,
        opened(network, "never") as plain,
    ):
        assert isinstance(wrong, LazyBrain)
        assert wrong._lazy is not None
        wrong._lazy.arrays.kinds["x_peak"] = 0.0
        expected = [spike for spike in fired(plain, 30.0) if spike[1] == 1]
        assert len(expected) == 1
        assert [spike for spike in fired(right, 30.0) if spike[1] == 1] == expected
        assert [spike for spike in fired(wrong, 30.0) if spike[1] == 1] == []


def test_a_busy_network_becomes_a_plain_grid_without_a_difference() -> None:
    """2000 cells that all fire; the change does not depend on how the run is divided."""
    busy = silent(2000, i_offset=np.linspace(0.5, 1.0, 2000), tau_refrac=2.0)  # type: ignore[arg-type]
    pairs = [(k, (7 * k + 1) % 2000) for k in range(2000)]
    network = kit.network(busy, kit.connect("n", "n", 0.4, 1.5, pairs=pairs))
    with opened(network, "always") as lazy, opened(network, "never") as plain:
        assert isinstance(lazy, LazyBrain)
        lazy._options = lazy._options.model_copy(update={"lazy": "auto"})
        lazy.run_until(from_milliseconds(33.3))
        assert lazy._lazy is not None
        assert fired(lazy, 160.0) == [spike for spike in fired(plain, 160.0) if spike[0] > 33.35]
        assert lazy._lazy is None


def test_a_network_that_the_lazy_grid_cannot_run_is_plain_and_a_warning_says_why(golden: Golden) -> None:
    event = EventBackend()
    options = EventOptions.model_validate({"resolution": "0.1 ms", "lazy": "always"})
    hard = kit.network(kit.cells(SAMPLES["IF_cond_exp"], "n", 3))
    (warning,) = event.warnings(hard, options)
    assert "`lazy: always` has no effect: IF_cond_exp of population 'n' has no closed form" in warning
    with event.open(hard, seed=1, options=options) as brain:
        assert not isinstance(brain, LazyBrain)
    auto = EventOptions.model_validate({"resolution": "0.1 ms"})
    few, restless = silent(10), silent(3000, i_offset=0.8)
    for cells, reason in ((few, "fewer than 2000"), (restless, "fire without input")):
        assert reason in lazy_grid_obstacle(kit.network(cells), auto)
        assert event.warnings(kit.network(cells), auto) == []
    assert lazy_grid_obstacle(kit.network(silent(3000)), auto) == ""
    with golden.raises(ValidationError):
        EventOptions.model_validate({"lazy": "always"})


def test_the_inputs_of_equal_receptors_cannot_be_parted(golden: Golden) -> None:
    with opened(kit.network(silent(2, tau_syn_I=2.0)), "always") as brain:
        brain.set_parameters(np.array([0]), {"tau_syn_E": 3.0, "tau_syn_I": 3.0})
        with golden.raises(CapabilityError, match="tau_syn_E.*tau_syn_I.*'n'"):
            brain.set_parameters(np.array([0]), {"tau_syn_E": 4.0})
