"""A complete network in one HDF5 file, versioned, and checked when it is read.

HDF5 because every language can read it. Every dataset has a checksum and the file has the network's
digest, so that the network read equals the network written. The layout::

    attributes    format, version, digest; timestep_ms and remarks (as JSON), if any
    populations/0, 1, ...    attributes label, size, cell_type; hints, equations (version 3) as JSON, if any
        parameters/*, initial_values/*    one value a cell, or one that all share
        spike_times_ms, spike_counts    if any; one train after the other, and how many spikes each has
        spike_train    the train of each cell, where cells share them (version 2); else one train a cell
        positions_um    if any
    projections/0, 1, ...    attributes label, pre, post, receptor, synapse_type; plasticity, origin as JSON;
                             equations (version 4), rewiring (version 5), neuromodulation
                             (version 6) as JSON, if any
        pre_index, post_index    one a synapse
        weight, delay_ms, synapse_parameters/*    one a synapse, or one that all share
        initial_values/*    the same, if any (version 5)
    views/0, 1, ...    attribute name
        neurons    global ids
    currents/0, 1, ...    if any (version 7)
        neurons, times_ms, amplitudes_na
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, fields
from hashlib import blake2b
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.files import replacing
from nrp_core.errors import NetworkError
from nrp_core.network.currents import InjectedCurrent
from nrp_core.network.data import Network, Origin, Population, Projection
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.equations.synapse import SynapseEquations
from nrp_core.network.files.hdf5 import array, attribute, group, reading
from nrp_core.network.limits import distinct
from nrp_core.network.picking import Selection, with_views
from nrp_core.network.rewiring import Neuromodulation, Rewiring
from nrp_core.paths import check_free, path_of

SUFFIX = ".nrpnet"
FORMAT = "nrp-network"
VERSION = 7
_WITH_CELLS, _WITH_SYNAPSES, _WITH_STATE, _WITH_REWARDS, _WITH_CURRENTS = 3, 4, 5, 6, 7
"""The first versions that know cells and synapses as equations, how synapses begin and vanish, rewards,
currents."""

_CHECKED = {"fletcher32": True, "shuffle": True, "compression": "gzip", "compression_opts": 1}

_TEXTS = ("label", "pre", "post", "receptor", "synapse_type")
"""Arrays of a projection."""
_LAYOUT = ("v110", "v110")
"""HDF5 1.10 (2016), the first version whose own structures have checksums."""

T = TypeVar("T")

_OTHERS: Final = {
    ".py": "scripts", ".nir": "files that save_nir writes", ".json": "configurations of circuits",
    ".yaml": "experiments", ".yml": "experiments",
}  # fmt: skip
"""Suffixes by which a network would be read as something else."""


@checks_arguments()
def save_network(network: Network, path: Path | str, *, overwrite: bool = False) -> None:
    """Write a network to a file.

    Args:
        network: the network.
        path: the file; by convention its name ends in ``.nrpnet``.
        overwrite: whether to replace an existing file, once the new one is complete.

    Raises:
        NetworkError: the file exists already, or cannot be written.
    """
    path = path_of(path, NetworkError)
    check_network_file(path, overwrite=overwrite)
    from nrp_core._support.hdf5 import new_file

    try:
        with replacing(path) as draft, new_file(draft, libver=_LAYOUT) as file:
            _write(file, network)
    except OSError as error:
        raise NetworkError(f"the network cannot be written: {error.strerror or error}", path=path) from error


def check_network_file(path: Path, *, overwrite: bool = False) -> None:
    """Refuse a file to which a network cannot be written.

    Raises:
        NetworkError: its folder does not exist, it exists and is not to be replaced, or it has the suffix of
            something else.
    """
    if not path.absolute().parent.is_dir():
        raise NetworkError("the folder does not exist", path=path.parent)
    check_free(path, overwrite=overwrite, error=NetworkError)
    if path.suffix in _OTHERS:
        raise NetworkError(
            f"'{path.suffix}' is the suffix of {_OTHERS[path.suffix]}; that of networks is '.nrpnet'",
            path=path,
        )


@checks_arguments()
def read_network(
    path: Path | str,
    *,
    populations: Mapping[str, Selection] | None = None,
    seed: int = 0,  # noqa: ARG001  readers of all kinds of files take it
) -> Network:
    """Read a network from a file.

    Args:
        path: the file.
        populations: additional named selections of neurons of the circuit.
        seed: has no effect, since the file holds no random values to draw.

    Raises:
        NetworkError: the file is missing, truncated or damaged, is of another format or a newer version, or
            holds an inconsistent network.
        NeuronSelectionError: ``populations`` reaches outside the circuit.
    """
    with reading(path_of(path, NetworkError)) as file:
        _require_format(file)
        cells = {cell.label: cell for cell in _parts(group(file, "populations"), _read_population)}
        projections = _parts(group(file, "projections"), _read_projection)
        views = dict(_parts(group(file, "views"), _read_view))
        timestep_ms = attribute(file, "timestep_ms", float) if "timestep_ms" in file.attrs else None
        remarks = (
            tuple(map(str, json.loads(attribute(file, "remarks", str)))) if "remarks" in file.attrs else ()
        )
        currents = _parts(group(file, "currents"), _read_current) if "currents" in file else ()
        network = Network(
            cells, tuple(projections), views, timestep_ms, remarks=remarks, currents=tuple(currents)
        )
        if attribute(file, "digest", str) != network.digest:
            raise NetworkError(
                "the file is damaged: the digest of its network differs from the digest stored in it"
            )
        return with_views(network, populations or {})


def _require_format(file: Any) -> None:
    if "format" not in file.attrs or attribute(file, "format", str) != FORMAT:
        raise NetworkError(
            f"this is an HDF5 file, but not a network file (its attribute 'format' is not '{FORMAT}')"
        )
    version = attribute(file, "version", int)
    if not 1 <= version <= VERSION:
        raise NetworkError(
            f"this is a network file of version {version}; this nrp-core reads versions up to {VERSION}: "
            "pip install --upgrade nrp-core"
        )


def _parts(parent: Any, read: Callable[[Any], T]) -> list[T]:
    """Return the contents of the groups ``0``, ``1``, ..."""
    return [read(group(parent, str(index))) for index in range(len(parent))]


def _write(file: Any, network: Network) -> None:
    _describe(file, format=FORMAT, version=1, digest=network.digest)
    if network.timestep_ms is not None:
        file.attrs["timestep_ms"] = network.timestep_ms
    if network.remarks:
        _describe(file, remarks=json.dumps(network.remarks))
    for index, population in enumerate(network.populations.values()):
        version = _write_population(file.create_group(f"populations/{index}"), population)
        file.attrs["version"] = max(version, int(file.attrs["version"]))
    for index, projection in enumerate(network.projections):
        version = _write_projection(file.create_group(f"projections/{index}"), projection)
        file.attrs["version"] = max(version, int(file.attrs["version"]))
    for index, (name, ids) in enumerate(network.views.items()):
        part = file.create_group(f"views/{index}")
        _describe(part, name=name)
        _write_array(part, "neurons", ids)
    for name in ("populations", "projections", "views"):
        file.require_group(name)
    for index, current in enumerate(network.currents):
        part = file.create_group(f"currents/{index}")
        for field in fields(current):
            _write_array(part, field.name, getattr(current, field.name))
        file.attrs["version"] = _WITH_CURRENTS


# -- populations


def _write_population(part: Any, population: Population) -> int:
    """Write a population; return the first format version that supports its features."""
    _describe(part, label=population.label, size=population.size, cell_type=population.cell_type)
    if population.hints:
        _describe(part, hints=json.dumps(dict(population.hints)))
    if population.equations is not None:
        _describe(part, equations=json.dumps(population.equations.data()))
    _put_all(part, "parameters", population.parameters)
    _put_all(part, "initial_values", population.initial_values)
    if population.positions_um is not None:
        _write_array(part, "positions_um", population.positions_um)
    are_shared = bool(population.spike_times_ms) and _write_trains(part, population.spike_times_ms)
    return _WITH_CELLS if population.equations is not None else 2 if are_shared else 1


def _write_trains(part: Any, trains: Sequence[FloatArray]) -> bool:
    """Write spike trains, equal trains once; return whether that omitted any."""
    contents = [blake2b(train.tobytes()).digest() for train in trains]
    distinct_trains = dict(zip(contents, trains, strict=True))
    if are_shared := sum(map(len, distinct_trains.values())) < sum(map(len, trains)):
        places = {content: place for place, content in enumerate(distinct_trains)}
        _write_array(part, "spike_train", np.array([places[content] for content in contents]))
        trains = list(distinct_trains.values())
    _write_array(part, "spike_times_ms", np.concatenate([np.empty(0), *trains]))
    _write_array(part, "spike_counts", np.array([len(train) for train in trains]))
    return are_shared


def _read_population(part: Any) -> Population:
    trains: tuple[FloatArray, ...] = ()
    if "spike_times_ms" in part:
        bounds = np.cumsum(array(part, "spike_counts", int))[:-1]
        trains = tuple(np.split(array(part, "spike_times_ms", float), bounds))
        if "spike_train" in part:
            trains = _share_trains(trains, array(part, "spike_train", int))
    size = attribute(part, "size", int)
    return Population(
        label=attribute(part, "label", str),
        size=size,
        cell_type=attribute(part, "cell_type", str),
        parameters=_get_all(part, "parameters", size),
        initial_values=_get_all(part, "initial_values", size),
        spike_times_ms=trains,
        positions_um=array(part, "positions_um", float) if "positions_um" in part else None,
        hints=_json(part, "hints") if "hints" in part.attrs else {},
        equations=CellEquations.from_data(_json(part, "equations")) if "equations" in part.attrs else None,
    )


def _share_trains(trains: tuple[FloatArray, ...], places: IntArray) -> tuple[FloatArray, ...]:
    for place in places[(places < 0) | (places >= len(trains))]:
        raise NetworkError(f"a cell has spike train {place}; its population has {len(trains)}, from 0 on")
    return tuple(trains[place] for place in places)


# -- projections and views


def _write_projection(part: Any, projection: Projection) -> int:
    """Write a projection; return the first format version that supports its features."""
    _describe(
        part,
        **{name: getattr(projection, name) for name in _TEXTS},
        plasticity=json.dumps(dict(projection.plasticity)),
        origin=json.dumps(asdict(projection.origin)),
    )
    if projection.equations is not None:
        _describe(part, equations=json.dumps(projection.equations.data()))
    if projection.rewiring is not None:
        _describe(part, rewiring=json.dumps(projection.rewiring.data()))
    if projection.neuromodulation is not None:
        _describe(part, neuromodulation=json.dumps(projection.neuromodulation.data()))
    _write_array(part, "pre_index", projection.pre_index)
    _write_array(part, "post_index", projection.post_index)
    _write_array(part, "weight", distinct(projection.weight))
    _write_array(part, "delay_ms", distinct(projection.delay_ms))
    _put_all(part, "synapse_parameters", projection.synapse_parameters)
    if projection.initial_values:
        _put_all(part, "initial_values", projection.initial_values)
    if projection.neuromodulation is not None:
        return _WITH_REWARDS
    if projection.rewiring is not None or projection.initial_values:
        return _WITH_STATE
    return _WITH_SYNAPSES if projection.equations is not None else 1


def _read_projection(part: Any) -> Projection:
    pre_index, post_index = array(part, "pre_index", np.int32), array(part, "post_index", np.int32)
    size = len(pre_index)
    return Projection(
        **{name: attribute(part, name, str) for name in _TEXTS},
        pre_index=pre_index,
        post_index=post_index,
        weight=_broadcast(array(part, "weight", float), size),
        delay_ms=_broadcast(array(part, "delay_ms", float), size),
        synapse_parameters=_get_all(part, "synapse_parameters", size),
        plasticity=_json(part, "plasticity"),
        origin=_origin(part),
        equations=SynapseEquations.from_data(_json(part, "equations")) if "equations" in part.attrs else None,
        initial_values=_get_all(part, "initial_values", size) if "initial_values" in part else {},
        rewiring=Rewiring.from_data(_json(part, "rewiring")) if "rewiring" in part.attrs else None,
        neuromodulation=(
            Neuromodulation.from_data(_json(part, "neuromodulation"))
            if "neuromodulation" in part.attrs
            else None
        ),
    )


def _origin(part: Any) -> Origin:
    try:
        return Origin(**_json(part, "origin"))
    except TypeError as error:
        raise NetworkError(f"the attribute 'origin' of '{part.name}' is not valid: {error}") from error


def _json(part: Any, name: str) -> dict[str, Any]:
    try:
        found = json.loads(attribute(part, name, str))
    except json.JSONDecodeError as error:
        raise NetworkError(f"the attribute '{name}' of '{part.name}' is not JSON: {error}") from error
    if not isinstance(found, dict):
        raise NetworkError(f"the attribute '{name}' of '{part.name}' is not a JSON object")
    return found


def _read_view(part: Any) -> tuple[str, Any]:
    return attribute(part, "name", str), array(part, "neurons", np.int64)


def _read_current(part: Any) -> InjectedCurrent:
    return InjectedCurrent(
        array(part, "neurons", np.int64), array(part, "times_ms", float), array(part, "amplitudes_na", float)
    )


# -- arrays


def _describe(part: Any, **values: str | int) -> None:
    """Write attributes; strings have fixed length, since HDF5 covers only those with checksums."""
    for name, value in values.items():
        if isinstance(value, str):
            text = value.encode()
            part.attrs[name] = np.array(text, dtype=f"S{max(1, len(text))}")
        else:
            part.attrs[name] = value


def _write_array(part: Any, name: str, values: np.ndarray[Any, Any]) -> None:
    part.create_dataset(name, data=values, **(_CHECKED if values.size > 1 else {}))


def _put_all(part: Any, name: str, arrays: Mapping[str, FloatArray]) -> None:
    within = part.create_group(name)
    for key, values in arrays.items():
        _write_array(within, key, distinct(values))


def _get_all(part: Any, name: str, size: int) -> dict[str, FloatArray]:
    within = group(part, name)
    return {key: _broadcast(array(within, key, float), size) for key in within}


def _broadcast(values: FloatArray, size: int) -> FloatArray:
    """Return a single value repeated ``size`` times, in the memory of one; other arrays unchanged."""
    return np.broadcast_to(values[0], (size,)) if values.shape == (1,) and size > 1 else values
