"""The resources of a SpiNNaker machine and the costs of its software: sizes, rates, energies.

Sizes are those of a 48-chip board under sPyNNaker 7.4.1. Instruction counts were taken from its released
binaries; 1.5 cycles an instruction and the cost of fetching a row are estimates.
"""

from __future__ import annotations

from typing import Final

CHIPS_PER_BOARD: Final = 48
BOARDS_PER_FRAME: Final = 24
LARGEST_MACHINE_CHIPS: Final = 57_600
CORES_FOR_SYSTEM_ON_ETHERNET_CHIP: Final = 3
CORES_FOR_SYSTEM: Final = 2
CORES_PER_CHIP: Final = 18
SYNAPSE_CORES: Final = CORES_PER_CHIP - CORES_FOR_SYSTEM - 1
"""Largest number of synapse-only cores for one core with neurons."""
SDRAM_BYTES: Final = 123_469_792
"""SDRAM of a chip available to applications, bytes."""
DTCM_BYTES: Final = 59 * 1024
"""DTCM of a core available for data, bytes."""
ROUTER_ENTRIES: Final = 1023
LONGEST_ROW: Final = 256
QUEUED_SPIKES: Final = 256
"""Spikes that a core can queue."""

NEURONS_PER_CORE: Final = 256
POISSON_SOURCES_PER_CORE: Final = 500
COLOUR_BITS: Final = 4

CYCLES_PER_US: Final = 200
CYCLES_PER_INSTRUCTION: Final = 1.5
ROW_FETCH_US: Final = 1.5
SYNAPSE_US: Final = 0.18
UPDATE_INSTRUCTIONS: Final = {
    "IF_curr_exp": 95, "IF_cond_exp": 127, "IF_curr_alpha": 120, "IF_curr_delta": 96,
    "IZK_curr_exp": 150, "IZK_cond_exp": 181, "Izhikevich": 150,
}  # fmt: skip
TRANSFER_INSTRUCTIONS: Final = 36
"""Instructions for both receptors of a neuron without input."""

BUSY: Final = 0.8
"""Load of a time step beyond which a core may be late; we assume that a reserve of a fifth is needed."""

LINK_PACKETS_PER_S: Final = 6e6
IDLE_BOARD_W: Final = 26.84
BOX_W: Final = 5.04
FRAME_W: Final = 117.0
ACTIVE_CORE_W: Final = 0.034
PACKET_HOP_J: Final = 1e-9
