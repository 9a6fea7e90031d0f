"""What exists is replaced only on request: by every command, and by every public function of Python."""

from __future__ import annotations

import errno
import importlib
import inspect
import os
import pkgutil
import re
import shutil
import typing
from collections.abc import Callable, Iterator
from dataclasses import is_dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import nrp_conformance.command
import numpy as np
import pytest
from nrp_formats import save_nir
from nrp_lab.paper import archive
from nrp_lab.sweep.figures import draw as draw_sweep
from nrp_lab.sweep.table import read_table
from public_names import DOORS, public_modules
from typer.main import get_command

from nrp_core.cli.app import build_app
from nrp_core.errors import NrpError
from nrp_core.experiment import load_experiment
from nrp_core.experiment.running.picture import Picture
from nrp_core.experiment.running.run import Run
from nrp_core.network.data import Network
from nrp_core.network.files import save_network
from nrp_core.network.files.script import load_network
from nrp_core.recording import figures
from nrp_core.recording.export import export
from nrp_core.recording.recording import Recording
from nrp_core.running import run

ROOT = Path(__file__).parents[3]
SHORT = ("--until", "0.04s")
BIBI = """<bibi xmlns="http://schemas.humanbrainproject.eu/SP10/2014/BIBI"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><brainModel><file>brain.py</file></brainModel>
  <transferFunction xsi:type="PythonTransferFunction">
@nrp.Robot2Neuron()
def idle(t):
    pass
</transferFunction></bibi>"""
V4 = """{"SimulationName": "s", "SimulationTimeout": 1, "EngineConfigs": [
  {"EngineType": "python_json", "EngineName": "one", "PythonFileName": "engine.py"}]}"""
ENGINE = """
from nrp_core.engines.python_json import EngineScript
class Script(EngineScript):
    pass
"""
CSV = """
@nrp.MapCSVRecorder("rows", "times.csv", ["t"])
@nrp.Robot2Neuron()
def note(t, rows):
    rows.record_entry(t)
"""
CELLS = """
import nrp_core.pynn as sim
sim.setup(timestep=0.1)
source = sim.Population(1, sim.SpikeSourceArray(spike_times=[1.0]), label="source")
cell = sim.Population(1, sim.IF_curr_delta(tau_refrac=0.0), label="cell")
sim.Projection(source, cell, sim.OneToOneConnector(), sim.StaticSynapse(weight=1.0, delay=0.1))
"""
SWEEP = "experiment: experiment\nsettings: {duration: 40 ms}\nvary: {events.go.publish.value: [1, 2]}\n"
SEARCH = (
    "experiment: experiment\nsettings: {duration: 40 ms}\n"
    "vary: {events.go.publish.value: {from: 0.1, to: 2.0}}\nobjective: {criterion_distance.stays_near: 1}\n"
    "missing: {criterion_distance.stays_near: 0}\npopulation: 3\ngenerations: 1\n"
)
OUTPUTS: dict[tuple[str, str], tuple[str, tuple[str, ...]]] = {
    ("run", "record"): ("out", ("run", "experiment", *SHORT, "--record")),
    ("run", "plot"): ("out.svg", ("run", "experiment", *SHORT, "--plot")),
    ("run", "save_brain"): ("out.nrpnet", ("run", "experiment", *SHORT, "--save-brain")),
    ("map", "html"): ("out.html", ("map", "experiment", "-s", "brain.backend=spinnaker", "--html")),
    ("inspect", "image"): ("out.png", ("inspect", "experiment/husky.sdf", "--image")),
    ("replay", "record"): ("out", ("replay", "recorded", "--record")),
    ("plot", "output"): ("out.svg", ("plot", "recorded", "devices", "-o")),
    ("video", "output"): ("out.webm", ("video", "recorded", *SHORT, "-o")),
    ("export", "output"): ("out.csv-tables", ("export", "recorded", "-f", "csv", "-o")),
    ("recover", "output"): ("out.mcap", ("recover", "recorded", "-o")),
    ("new", "output"): ("out", ("new", "brain", "mine", "-o")),
    ("conformance", "report"): ("out.json", ("conformance", "brain", "event", "--report")),
    ("diff", "html"): ("out.html", ("diff", "recorded", "recorded_too", "--html")),
    ("evolve", "plot"): ("out.svg", ("evolve", "show", "search.evolve", "--plot")),
    ("generate", "output"): ("out.py", ("generate", "model.bibi", "-o")),
    ("generate", "diagram"): ("out.svg", ("generate", "model.bibi", "--diagram")),
    ("import", "output"): ("out", ("import", "v4/simulation_config.json", "-o")),
    ("import-connectome", "output"): ("out.nrpnet", ("import-connectome", "edges.csv", "-o")),
    ("paper", "output"): ("out.zip", ("paper", "experiment", "--seeds", "1", "-s", "duration=40 ms", "-o")),
    ("share", "output"): ("out.html", ("share", "recorded", "-o")),
    ("sweep", "plot"): ("out.svg", ("sweep", "show", "grid.sweep", "--plot")),
}
"""For each option that names a file or folder to write: one, and the command line before it."""
CONTINUED = {
    ("benchmark", "out"): ("benchmark", "phototaxis", "--seeds", "1", "--worlds", "no_such", "--out"),
    ("diff", "results"): ("diff", "experiment", "--worlds", "disc,no_such", "--results"),
    ("evolve", "out"): ("evolve", "search.yaml", "--out"),
    ("sweep", "out"): ("sweep", "grid.yaml", "--out"),
}
"""Folders whose runs are reused."""
OTHERS = {
    ("run", "control"), ("publish", "socket"), ("functions", "socket"),  # of a run
    ("diff", "baseline"), ("diff", "animal"),  # files that are read
    *((command, "models") for command in ("run", "validate", "map", "inspect", "diff", "import", "paper")),
    ("cockpit", "models"), ("design", "models"),
    *((command, "recording") for command in ("replay", "plot", "video", "export", "recover", "share")),
    ("functions", "add"), ("inspect", "file"), ("new", "robot"), ("replay", "functions"), ("diff", "other"),
    ("conformance", "scene"), ("generate", "file"), ("import", "file"), ("import-connectome", "edges"),
    ("import-connectome", "neurons"), ("import-connectome", "junctions"), ("evolve", "folder"),
    ("sweep", "folder"),
}  # fmt: skip
"""Options and arguments that name a file to read."""


def named_paths() -> Iterator[tuple[str, str]]:
    """Yield each registered command and each of its parameters that takes paths."""
    app = get_command(build_app())
    for name in app.list_commands(None):
        callback = app.get_command(None, name).callback
        for parameter, hint in typing.get_type_hints(callback).items():
            if Path in (hint, *typing.get_args(hint)) or list[Path] in typing.get_args(hint):
                yield name, parameter


@pytest.fixture
def here(nrp, experiment: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder: it has all that the command lines name."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(experiment, "experiment")
    Path("model.bibi").write_text(BIBI)
    Path("edges.csv").write_text("pre,post,weight\n1,2,-3\n")
    Path("v4").mkdir()
    Path("v4/simulation_config.json").write_text(V4)
    Path("v4/engine.py").write_text(ENGINE)
    Path("csv.py").write_text(CSV)
    Path("cells.py").write_text(CELLS)
    Path("grid.yaml").write_text(SWEEP)
    Path("search.yaml").write_text(SEARCH)
    return tmp_path


def prepare(nrp: Callable[..., Any], arguments: tuple[str, ...]) -> None:
    """Make the recordings and results that a command line reads."""
    for name in {"recorded", "recorded_too"} & set(arguments):
        assert nrp("run", "experiment", *SHORT, "--record", name).code == 0
    for name in {"grid.sweep", "search.evolve"} & set(arguments):
        stem, command = name.split(".")
        assert nrp(command, f"{stem}.yaml", "--workers", 1).code == 0


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def no_space(_: int) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_each_path_that_a_command_takes_is_known_to_be_read_or_written() -> None:
    assert set(named_paths()) == {*OUTPUTS, *CONTINUED, *OTHERS}


@pytest.mark.one_of(8)
@pytest.mark.parametrize(("name", "parameter"), OUTPUTS)
def test_a_command_replaces_what_exists_on_request_only_and_as_a_whole(
    nrp, here: Path, monkeypatch: pytest.MonkeyPatch, name: str, parameter: str
) -> None:
    # minutes of tests, and seconds of figures
    monkeypatch.setattr(nrp_conformance.command, "_run", lambda *_: {"conforms": False})
    monkeypatch.setattr(nrp_conformance.command, "_print", lambda *_: None)
    monkeypatch.setattr(archive, "_write_figures", lambda _, folder: folder.mkdir())
    target, arguments = OUTPUTS[name, parameter]
    prepare(nrp, arguments)
    first = nrp(*arguments, target)
    assert first.code in (0, 1), first.err
    place = Path(target)
    mine = place / "mine.txt" if place.is_dir() else place
    mine.write_text("precious")
    before = contents(here)
    refused = nrp(*arguments, target)
    assert refused.code == 2
    assert "--overwrite" in refused.err
    assert contents(here) == before
    if place.is_file():
        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", no_space)
            failed = nrp(*arguments, target, "--overwrite")
            assert failed.code not in (0, 1) or "space" in failed.err, failed.out
        assert contents(here) == before
    again = nrp(*arguments, target, "--overwrite")
    assert again.code == first.code, again.err
    if place.is_dir():
        assert not mine.exists() or mine.read_text() == "precious"
    else:
        assert mine.read_bytes() != b"precious"
    if name not in ("run", "conformance", "import", "map"):  # which write nothing without the option
        require_the_rule_for_the_own_name_of(nrp, here, arguments[:-1])


def require_the_rule_for_the_own_name_of(nrp, here: Path, arguments: tuple[str, ...]) -> None:
    """Run a command without a name of its output: it prints, or writes what it then refuses to replace."""
    before = contents(here)
    done = nrp(*arguments)
    assert done.code in (0, 1), done.err
    after = contents(here)
    if after != before:
        assert nrp(*arguments).code == 2
        assert contents(here) == after


@pytest.mark.parametrize(("name", "parameter"), CONTINUED)
def test_a_folder_of_results_keeps_files_of_others(nrp, here: Path, name: str, parameter: str) -> None:
    folder = here / "results"
    folder.mkdir()
    (folder / "mine.txt").write_text("precious")
    nrp(*CONTINUED[name, parameter], folder)
    assert (folder / "mine.txt").read_text() == "precious"


def test_the_socket_of_a_run_replaces_no_file(nrp, here: Path) -> None:
    Path("mine.txt").write_text("precious")
    assert nrp("run", "experiment", *SHORT, "--control", "mine.txt").code != 0
    assert Path("mine.txt").read_text() == "precious"


READING = re.compile(
    r"(read|load|is|are|find|check|require|open|has|in|inspect|validate|changes|unpack)(_|$)"
)
"""How functions are called that read the files which they are given."""
WITHOUT_OUTPUT = {
    "nrp_core.recording.file_digest", "nrp_core.cli.new_robot.robot_values",
    "nrp_core.Experiment.with_csv_folder", "nrp_core.brain.Findings.add",
    "nrp_core.experiment.RunObserver.functions_changed", "nrp_core.experiment.experiments_in",
    "nrp_core.experiment.network_from", "nrp_core.recording.Dependencies.to_data",
    "nrp_core.recording.FilesRead.below", "nrp_core.recording.FilesRead.elsewhere",
    "nrp_core.recording.dependencies", "nrp_core.utilities.new_file", "nrp_core.utilities.replace_file",
    "nrp_core.utilities.replacing", "nrp_core.utilities.writing", "nrp_lab.sweep.sweep",
    "nrp_lab.evolve.evolve", "nrp_lab.benchmark.Ladder", "nrp_lab.learning.Ladder",
    "nrp_core.cli.inspect_experiments.declared_parameters", "nrp_core.cli.options.overrides_of",
    "nrp_core.cli.options.folder_to_show", "nrp_core.cli.options.results_folder",
    "nrp_core.cli.summary.summary", "nrp_core.network.files.hdf5.reading",
    "nrp_core.network.files.script.scope_of", "nrp_core.network.native.native_network",
    "nrp_core.network.pynn.equation_models.nestml_cell",
    "nrp_core.paths.TextFrom.of", "nrp_core.pynn.languages.Language.compiled",
    "nrp_core.pynn.languages.ScriptReading.compiled", "nrp_core.pynn.runners.run_as_main",
    "nrp_core.pynn.languages.ScriptReading.remarks", "nrp_core.pynn.languages.reading_of",
    "nrp_core.scripts.compile_file",
    "nrp_core.recording.figures.save", "nrp_core.recording.folder.recording_folder.write_experiment",
    "nrp_core.scene.meshes.stl.write_stl", "nrp_core.scene.meshes.stl.write_coordinates",
    "nrp_core.scene.reading.context.package_name", "nrp_core.scene.reading.context.Resources",
    "nrp_core.scene.reading.context.Resources.package", "nrp_core.scene.reading.context.main_file",
    "nrp_core.scene.reading.context.listed_file", "nrp_core.scripts.Scope", "nrp_core.scripts.Scope.run",
    "nrp_core.scripts.Scope.located", "nrp_core.world.robot_setup.models_for", "nrp_core.xml.parse_xml",
    "nrp_lab.gym.NrpEnv", "nrp_lab.gym.NrpProcessesEnv", "nrp_lab.gym.NrpVectorEnv", "nrp_lab.gym.make_env",
    "nrp_lab.gym.make_vec", "nrp_lab.gym.parallel.NrpParallelEnv", "nrp_lab.sweep.record.Journal",
    "nrp_lab.sweep.record.records_in",
    "nrp_lab.sweep.report.report_data", "nrp_lab.sweep.table.claim", "nrp_lab.sweep.table.write_rows",
    "nrp_lab.sweep.table.write_tables",
}  # fmt: skip
"""Functions that take paths and have no ``overwrite``: they read, continue a folder, or help to write."""
NETWORK = Network({}, timestep_ms=1.0)
PICTURE = Picture(np.zeros((2, 2, 3), np.uint8), "a run", {})
FUNCTIONS: dict[str, tuple[str, Callable[..., Any]]] = {
    "nrp_core.run": ("out", lambda path, **rule: run("experiment", until_s=0.04, record=path, **rule)),
    "nrp_core.save_network": ("out.nrpnet", lambda path, **rule: save_network(NETWORK, path, **rule)),
    "nrp_core.Recording.plot": (
        "out.svg",
        lambda path, **rule: Recording("recorded").plot("devices", path, **rule),
    ),
    "nrp_core.Recording.video": ("out.webm", lambda path, **rule: Recording("recorded").video(path, **rule)),
    "nrp_core.Run.write_csv": ("out", lambda path, **rule: noted(path, **rule)),
    "nrp_core.recording.figures.plot": (
        "out.svg",
        lambda path, **rule: figures.plot(Recording("recorded"), path, figures.What.DEVICES, **rule),
    ),
    "nrp_formats.save_nir": (
        "out.nir",
        lambda path, **rule: save_nir(load_network("cells.py"), path, **rule),
    ),
    "nrp_lab.sweep.figures.draw": (
        "out.svg",
        lambda path, **rule: draw_sweep(read_table(Path("grid.sweep")), path, **rule),
    ),
    "of a run: Picture.save": ("out.png", lambda path, **rule: PICTURE.save(path, **rule)),
    "of nrp export": (
        "out.csv-tables",
        lambda path, **rule: export(Recording("recorded"), "csv", path, **rule),
    ),
}
"""For each function that has ``overwrite``: a file or folder to write, and a call."""


def noted(folder: Path, **rule: bool) -> None:
    """Run for two steps and write the rows of a recorder."""
    with Run(load_experiment("experiment", ["transfer_functions=[experiment/drive.py, csv.py]"])) as made:
        made.run(0.04)
        for _ in range(2):
            made.write_csv(folder, **rule)  # the second time it replaces its own


def modules() -> Iterator[str]:
    """Yield the doors and the public modules."""
    yield from DOORS
    for name in sorted(public_modules()):
        if name.endswith("*"):
            package = importlib.import_module(name[:-2])
            yield from (one.name for one in pkgutil.iter_modules(package.__path__, name[:-1]))
        else:
            yield name


def members(module: ModuleType) -> Iterator[tuple[str, object]]:
    names = getattr(module, "__all__", None)
    for name, value in [(name, getattr(module, name)) for name in names or vars(module)]:
        if names or (not name.startswith("_") and getattr(value, "__module__", "") == module.__name__):
            yield f"{module.__name__}.{name}", value


def public_functions() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Yield the public functions, methods and constructors that take paths, each once."""
    known: set[int] = set()
    for module in modules():
        for name, value in members(importlib.import_module(module)):
            if id(value) in known or (isinstance(value, type) and issubclass(value, BaseException)):
                continue
            known.add(id(value))
            for full, function in functions_of(name, value):
                parameters = inspect.signature(function).parameters.values()
                if any(re.search(r"\bPath\b", str(one.annotation)) for one in parameters):
                    yield full, function


def functions_of(name: str, value: object) -> Iterator[tuple[str, Callable[..., Any]]]:
    if inspect.isfunction(value):
        yield name, value
    elif isinstance(value, type):
        for own, method in list(vars(value).items()):
            function = getattr(method, "__func__", method)
            if own == "__init__" and not is_dataclass(value):
                yield name, function
            elif not own.startswith("_") and inspect.isfunction(function):
                yield f"{name}.{own}", function


def test_each_public_function_that_takes_a_path_is_known_to_read_or_write() -> None:
    names = {
        name: function for name, function in public_functions() if not READING.match(name.split(".")[-1])
    }
    with_rule = {name for name, made in names.items() if "overwrite" in inspect.signature(made).parameters}
    assert with_rule - {"nrp_core.recording.RecordingFolder"} == {
        name for name in FUNCTIONS if " " not in name
    }
    assert names.keys() - with_rule == WITHOUT_OUTPUT


@pytest.mark.one_of(6)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_replaces_what_exists_on_request_only_and_as_a_whole(
    nrp, here: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    target, call = FUNCTIONS[name]
    uses = {"nrp_core.run": (), "nrp_lab.sweep.figures.draw": ("grid.sweep",)}
    prepare(nrp, uses.get(name, ("recorded",)))
    call(Path(target))
    before = contents(here)
    with pytest.raises(NrpError, match="overwrite=True"):
        call(Path(target))
    if Path(target).is_file():
        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", no_space)
            with pytest.raises(NrpError):
                call(Path(target), overwrite=True)
    assert contents(here) == before
    call(Path(target), overwrite=True)


def test_rows_of_an_earlier_run_are_refused_before_the_next_one(nrp, here: Path) -> None:
    line = ("run", "experiment", *SHORT, "-s", "transfer_functions=[experiment/drive.py, csv.py]")
    assert nrp(*line).code == 0
    (rows,) = here.rglob("times.csv")
    rows.write_text("precious")
    refused = nrp(*line)
    assert (refused.code, rows.read_text()) == (2, "precious")
    assert "--overwrite" in refused.err
    assert nrp(*line, "--overwrite").code == 0
    assert rows.read_text().startswith("t\n")


def test_a_recording_replaces_a_recording_and_nothing_else(nrp, experiment: Path, tmp_path: Path) -> None:
    folder = tmp_path / "again"
    assert nrp("run", experiment, "--until", "0.1s", "--record", folder).code == 0
    assert nrp("run", experiment, "--until", "0.04s", "--record", folder, "--overwrite").code == 0
    assert Recording(folder).run["result"]["steps"] == 2
    inside = folder / "experiment.yaml"
    assert nrp("run", inside, "--record", folder, "--overwrite").code != 0
    assert inside.exists(), "what the run reads is not removed"
    other = tmp_path / "other"
    other.mkdir()
    (other / "mine.txt").write_text("precious")
    assert nrp("run", experiment, "--record", other, "--overwrite").code == 2
    assert (other / "mine.txt").read_text() == "precious"
