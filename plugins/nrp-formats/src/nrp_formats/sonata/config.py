"""The configuration of a SONATA circuit, which lists its files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Final

from nrp_core.errors import NetworkError
from nrp_formats.sonata.attribute_checks import is_read_clamp, unused_settings
from nrp_formats.sonata.items import read_object

_SECTIONS: Final = (
    "manifest", "networks", "components", "node_sets_file", "network", "target_simulator", "simulation",
    "run", "conditions", "inputs", "output", "reports",
)  # fmt: skip
"""Those of a circuit and of a simulation."""
_CONFIGS: Final = ("network", "simulation")
"""The keys of other files of the configuration."""
_NETWORKS: Final = ("nodes", "edges")
_FOLDERS: Final = ("point_neuron_models_dir", "synaptic_models_dir")
"""The folders of 'components' that are read; circuits have others."""
_ALIKE: Final = 0.85


@dataclass(frozen=True, slots=True)
class Files:
    """The nodes or edges of one or more populations: an HDF5 file and the table of their types, if any."""

    data: Path
    types: Path | None


@dataclass(frozen=True, slots=True)
class Config:
    """A circuit.

    Args:
        nodes, edges: the files of nodes and edges.
        point_neuron_models, synaptic_models: folders with parameters of types.
        spikes: the spikes of virtual nodes, a file and the node set, or an empty text, for each input.
        node_sets: files of node sets; a later set overrides an earlier one of the same name.
        targets: the node set of each input of spikes that names one.
        clamps: the inputs of currents.
        unused: sentences about settings of the simulation that no network has.
    """

    nodes: tuple[Files, ...]
    edges: tuple[Files, ...]
    point_neuron_models: Path
    synaptic_models: Path
    spikes: tuple[tuple[Path, str], ...] = ()
    node_sets: tuple[Path, ...] = ()
    targets: Mapping[str, str] = field(default_factory=dict)
    clamps: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    unused: tuple[str, ...] = ()


def read_config(path: Path) -> Config:
    """Read the configuration of a circuit, of a simulation that names a circuit, or of both.

    Raises:
        NetworkError: not a valid configuration, or it names a file that does not exist.
    """
    given = _resolved(path)
    if isinstance(given.get("simulation"), str):  # the file names the other two
        given = {**_resolved(path.parent / given["simulation"]), **given}
    circuit = given
    if isinstance(given.get("network"), str):
        circuit = _resolved(path.parent / given["network"])
    networks, components = _section(path, circuit, "networks"), _section(path, circuit, "components")
    if not networks.get("nodes"):
        raise NetworkError("the configuration has no 'networks' with 'nodes'", path=path)
    for part in (circuit, given):
        _require_spelt(path, "the configuration", part, _SECTIONS)
    _require_spelt(path, "'networks'", networks, _NETWORKS)
    _require_spelt(path, "components", components, _FOLDERS)
    for key in _NETWORKS:
        if not isinstance(networks.get(key) or [], list):
            raise NetworkError(f"'networks.{key}' of the configuration is not a list", path=path)
    sets = {name: None for part in (circuit, given) if (name := _text(path, part, "node_sets_file"))}
    for name in ("conditions", "run", "inputs", "reports"):
        if misplaced := _section(path, given, name).keys() & set(_SECTIONS):
            wrong = f"'{min(misplaced)}' of the configuration is in '{name}', where nothing reads it"
            raise NetworkError(wrong, path=path)
    inputs = _section(path, given, "inputs")
    if not all(isinstance(entry, Mapping) for entry in inputs.values()):
        raise NetworkError("an entry of 'inputs' is not a JSON object", path=path)
    inputs = {name: entry for name, entry in inputs.items() if entry.get("enabled") is not False}
    return Config(
        nodes=tuple(_files(path, entry, "node") for entry in networks["nodes"]),
        edges=tuple(_files(path, entry, "edge") for entry in networks.get("edges") or ()),
        point_neuron_models=Path(_text(path, components, "point_neuron_models_dir") or path.parent),
        synaptic_models=Path(_text(path, components, "synaptic_models_dir") or path.parent),
        spikes=tuple(_spikes(path, inputs)),
        node_sets=tuple(map(Path, sets)),
        targets={
            name: entry["node_set"]
            for name, entry in inputs.items()
            if entry.get("input_type") == "spikes" and isinstance(entry.get("node_set"), str)
        },
        clamps={name: entry for name, entry in inputs.items() if is_read_clamp(entry)},
        unused=tuple(unused_settings({**given, "inputs": inputs})),
    )


def _require_spelt(path: Path, what: str, given: Mapping[str, Any], known: tuple[str, ...]) -> None:
    """Refuse a key that is nearly one that is missing."""
    missing = [name for name in known if name not in given]
    for key in given:
        if key not in known and (near := get_close_matches(key.lower(), missing, 1, _ALIKE)):
            raise NetworkError(f"{what} has no key '{key}'; did you mean '{near[0]}'?", path=path)


def _spikes(path: Path, inputs: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[Path, str]]:
    for name, entry in inputs.items():
        if entry.get("input_type") == "spikes":
            if not isinstance(entry.get("input_file"), str):
                raise NetworkError(f"the input '{name}' of spikes names no 'input_file'", path=path)
            nodes = entry.get("node_set")
            yield Path(entry["input_file"]), nodes if isinstance(nodes, str) else ""


def _resolved(path: Path) -> dict[str, Any]:
    """Return a configuration with its manifest's variables substituted and its paths made absolute."""
    given = read_object(path, "the configuration")
    own = {str(name): str(value) for name, value in _section(path, given, "manifest").items()}
    variables = {"$configdir": str(path.parent.resolve()), "$workingdir": str(Path.cwd())} | own
    for _ in variables:  # a variable may contain others
        variables = {name: _put_in(value, variables) for name, value in variables.items()}
    found = _walked({key: value for key, value in given.items() if key != "manifest"}, variables, path.parent)
    assert isinstance(found, dict)
    return found


def _section(path: Path, config: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = config.get(name) or {}
    if not isinstance(found, Mapping):
        raise NetworkError(f"'{name}' of the configuration is not a JSON object", path=path)
    return found


def _text(path: Path, section: Mapping[str, Any], name: str) -> str | None:
    """Return the file or folder under a key, or None.

    Raises:
        NetworkError: it is not a text.
    """
    found = section.get(name)
    if found is not None and not isinstance(found, str):
        raise NetworkError(f"'{name}' of the configuration is {found!r:.60}, not a path", path=path)
    return found


def _walked(value: Any, variables: Mapping[str, str], folder: Path) -> Any:
    if isinstance(value, Mapping):
        return {
            key: _as_path(item, variables, folder)
            if _is_path(key, item)
            else _walked(item, variables, folder)
            for key, item in value.items()
        }
    return [_walked(item, variables, folder) for item in value] if isinstance(value, list) else value


def _is_path(key: str, value: object) -> bool:
    return isinstance(value, str) and (key.endswith(("_file", "_dir")) or key in (*_CONFIGS, "file"))


def _as_path(value: str, variables: Mapping[str, str], folder: Path) -> str:
    return str((folder / _put_in(value, variables)).resolve())


def _put_in(text: str, variables: Mapping[str, str]) -> str:
    """Return a text with names replaced by their variables, the longest names first."""
    for name in sorted(variables, key=len, reverse=True):
        text = text.replace("${" + name.lstrip("$") + "}", variables[name]).replace(name, variables[name])
    return text


def _files(path: Path, entry: Any, kind: str) -> Files:
    if not isinstance(entry, Mapping) or not isinstance(entry.get(f"{kind}s_file"), str):
        raise NetworkError(f"an entry of '{kind}s' names no '{kind}s_file': {entry!r:.80}", path=path)
    _require_spelt(path, f"an entry of '{kind}s'", entry, (f"{kind}s_file", f"{kind}_types_file"))
    types = _text(path, entry, f"{kind}_types_file")
    return Files(Path(entry[f"{kind}s_file"]), None if types is None else Path(types))
