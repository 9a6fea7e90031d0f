"""The sign of the synapses of a neurotransmitter in the fly's brain (as in Shiu et al. 2024)."""

from __future__ import annotations

from typing import Final

EXCITATORY: Final = frozenset(
    {
        "ach",
        "acetylcholine",
        "da",
        "dopamine",
        "ser",
        "serotonin",
        "oct",
        "octopamine",
        "histamine",
        "tyramine",
    }
)
INHIBITORY: Final = frozenset({"gaba", "glut", "glutamate"})


def sign_of(transmitter: str | None) -> int:
    """Return 1 or -1, or 0 for an unknown transmitter."""
    name = (transmitter or "").strip().lower()
    return 1 if name in EXCITATORY else -1 if name in INHIBITORY else 0
