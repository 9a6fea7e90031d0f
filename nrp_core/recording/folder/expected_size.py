"""The size of a recording before the run, as far as the sources of spikes determine it."""

from __future__ import annotations

from nrp_core.clock import seconds
from nrp_core.experiment.running.run import Run
from nrp_core.network.data import Population

LARGE_BYTES = 300_000_000
"""From this size on a user is told before the run."""
_BYTES_PER_SPIKE = 10.1
"""Compressed with the messages around them; measured with 20 million spikes of one source."""


def expected_spikes(population: Population, from_s: float, until_s: float) -> float:
    """Return the expected number of spikes of the sources of a population in a period; 0 for other cells."""
    own = population.parameters
    if population.spike_times_ms:
        return float(
            sum(((from_s <= t / 1e3) & (t / 1e3 < until_s)).sum() for t in population.spike_times_ms)
        )
    if not population.is_source or not {"rate", "start", "duration"} <= own.keys():
        return 0.0
    begin_s, end_s = own["start"] / 1e3, (own["start"] + own["duration"]) / 1e3
    active_s = (end_s.clip(max=until_s) - begin_s.clip(min=from_s)).clip(min=0.0)
    return float((own["rate"] * active_s).sum())


def size_note(run: Run, until_s: float | None = None) -> str | None:
    """Return a sentence about a recording that will be large because of its sources; None if it will not be.

    Args:
        run: the run, before it is recorded.
        until_s: simulated time to which it is recorded, s; by default the duration of the experiment.
    """
    end_s = seconds(run.experiment.duration) if until_s is None else until_s
    sizes = {
        label: _BYTES_PER_SPIKE * expected_spikes(population, run.now_s, end_s)
        for label, population in run.brain.network.populations.items()
        if label not in run.experiment.recording.exclude
    }
    total = sum(sizes.values())
    if total < LARGE_BYTES:
        return None
    largest = max(sizes, key=lambda label: sizes[label])
    return (
        f"the recording will be larger than {total / 1e6:.0f} MB, {sizes[largest] / 1e6:.0f} MB of it "
        f"spikes of the source '{largest}'; the setting recording.exclude=[{largest}] leaves them out"
    )
