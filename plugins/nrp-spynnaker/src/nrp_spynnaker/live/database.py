"""The database in which programs of sPyNNaker look up the keys of cells and where spikes go.

It has what version 7 of SpiNNFrontEndCommon reads: tables in place of the views there.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

from nrp_spynnaker.live.board import PORT, TAG, place_of

_TABLES = """
CREATE TABLE configuration_parameters(parameter_id TEXT PRIMARY KEY, value REAL);
CREATE TABLE proxy_configuration(kind TEXT, name TEXT, value TEXT);
CREATE TABLE label_event_atom_view(label TEXT, event INTEGER, atom INTEGER);
CREATE TABLE app_output_tag_view(
    pre_vertex_label TEXT, post_vertex_label TEXT, ip_address TEXT, port INTEGER, strip_sdp INTEGER,
    board_address TEXT, tag INTEGER, chip_x INTEGER, chip_y INTEGER);
CREATE TABLE application_vertex_placements(vertex_label TEXT, x INTEGER, y INTEGER, p INTEGER);
CREATE TABLE chip_eth_info(x INTEGER, y INTEGER, eth_x INTEGER, eth_y INTEGER, eth_ip_address TEXT);
"""
_RECEIVER = "LiveSpikeReceiver"
"""What connections call the part of the machine that passes spikes on."""
_FOREVER = -1.0


def write_database(
    path: Path, address: str, keys: Mapping[str, range], sent: list[str], cores: list[str],
    timestep_ms: float, run_time_ms: float,
) -> None:  # fmt: skip
    """Write the database; a file that is there is replaced.

    Args:
        path: its file.
        address: the IP address of the board.
        keys: of the cells of populations, in their order, by label.
        sent: the populations whose spikes are sent.
        cores: the populations that receive spikes, in the order of their cores.
        timestep_ms: the time step.
        run_time_ms: the time to run; infinite, if there is no end.
    """
    path.unlink(missing_ok=True)
    with closing(sqlite3.connect(path)) as database, database:
        database.executescript(_TABLES)
        fill = database.executemany
        fill(
            "INSERT INTO configuration_parameters VALUES (?, ?)",
            [
                ("machine_time_step", 1000.0 * timestep_ms),
                ("time_scale_factor", 1.0),
                ("runtime", run_time_ms if run_time_ms < float("inf") else _FOREVER),
            ],
        )
        for label, numbers in keys.items():
            rows = ((label, key, cell) for cell, key in enumerate(numbers))
            fill("INSERT INTO label_event_atom_view VALUES (?, ?, ?)", rows)
        outputs = [(label, _RECEIVER, address, PORT, 1, address, TAG, 0, 0) for label in sent]
        fill("INSERT INTO app_output_tag_view VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", outputs)
        places = [(label, *place_of(core)) for core, label in enumerate(cores)]
        fill("INSERT INTO application_vertex_placements VALUES (?, ?, ?, ?)", places)
        database.execute("INSERT INTO chip_eth_info VALUES (0, 0, 0, 0, ?)", (address,))
