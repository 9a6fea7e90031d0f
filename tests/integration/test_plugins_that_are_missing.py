"""What needs a distribution that is not installed names it, and the command that installs it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from nrp_core import registry
from nrp_core.cli import app
from nrp_core.errors import ExperimentError, NetworkError, NrpError, UnknownBackendError
from nrp_core.experiment.making.maker import network_from
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.findings import Code
from nrp_core.network.files.script import load_network
from nrp_core.pynn.__main__ import main
from nrp_core.running import open_run
from nrp_core.scene.sdf import read_model


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Only the core is installed."""
    found = registry.entries

    def of_the_core(group: str) -> list[registry.EntryPoint]:
        return [one for one in found(group) if one.dist is not None and one.dist.name == "nrp-core"]

    monkeypatch.setattr(registry, "entries", of_the_core)
    monkeypatch.setattr(registry, "_SETUP", Path("not in a clone"))
    registry._providers.cache_clear()
    yield
    registry._providers.cache_clear()


def requires(error: NrpError | str, distribution: str) -> bool:
    return f"is in {distribution}, which is not installed; try: pip install {distribution}" in str(error)


@pytest.mark.parametrize("place", ["x.exc", ""], ids=["the file", "its folder"])
def test_an_old_experiment(tmp_path: Path, place: str) -> None:
    (tmp_path / "x.exc").write_text("<ExD/>")
    with pytest.raises(ExperimentError) as caught:
        load_experiment(tmp_path / place)
    assert requires(caught.value, "nrp-legacy")
    assert caught.value.path == tmp_path / "x.exc"


def test_an_experiment_that_names_the_platform(tmp_path: Path) -> None:
    path = tmp_path / "experiment.yaml"
    path.write_text("{extends: braitenberg_husky, compatibility: {platform: hbp_nrp}}")
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    assert requires(caught.value, "nrp-legacy")


def test_a_plugin_of_a_robot(tmp_path: Path) -> None:
    path = tmp_path / "robot.sdf"
    path.write_text(
        '<sdf version="1.9"><model name="r"><link name="l"/><plugin name="gz::sim::systems::Thruster" '
        'filename="gz-sim-thruster-system"/></model></sdf>'
    )
    (finding,) = (each for each in read_model(path).warnings if each.subject == "Thruster")
    assert finding.code is Code.NRP260
    assert "nrp-medium" in finding.message


@pytest.mark.parametrize(
    ("command", "distribution"),
    [
        ("import", "nrp-legacy"),
        ("sweep", "nrp-lab"),
        ("import-connectome", "nrp-formats"),
        ("share", "nrp-cockpit"),
        ("demo", "nrp-cockpit"),
        ("ros-bridge", "nrp-world-ros"),
    ],
)
def test_a_command(command: str, distribution: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert app.run_app([command, "x"]) != 0
    assert requires(" ".join(capsys.readouterr().err.split()), distribution)


@pytest.mark.parametrize(
    ("key", "distribution"),
    [("brain.backend=nest", "nrp-brain-nest"), ("world.backend=drake", "nrp-world-drake")],
)
def test_a_backend(key: str, distribution: str) -> None:
    with pytest.raises(UnknownBackendError) as caught, open_run("following_head", [key]):
        pass
    assert requires(caught.value, distribution)


def test_a_command_in_a_clone(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.undo()
    monkeypatch.setattr(registry.Registry, "providers", lambda self: [])
    assert app.run_app(["sweep", "x"]) == 4
    assert "try: scripts/setup nrp-lab" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["net.nir", "circuit_config.json"])
def test_a_network_in_the_file_of_another_program(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("{}")
    with pytest.raises(NetworkError) as caught:
        network_from(tmp_path / name)
    assert requires(caught.value, "nrp-formats")
    assert caught.value.path == tmp_path / name


SCRIPT = "import {} as sim\nsim.setup()\n"


@pytest.mark.parametrize("module", ["pyNN.spiNNaker", "spynnaker.pyNN", "spynnaker8"])
def test_a_brain_file_for_another_simulator(tmp_path: Path, module: str) -> None:
    (tmp_path / "brain.py").write_text(SCRIPT.format(module))
    with pytest.raises(UnknownBackendError) as caught:
        load_network(tmp_path / "brain.py")
    assert requires(caught.value, "nrp-spynnaker")


@pytest.mark.parametrize("options", [[], ["--as", "spinnaker"]], ids=["by default", "as such"])
def test_a_script_for_another_simulator(tmp_path: Path, options: list[str]) -> None:
    (tmp_path / "script.py").write_text(SCRIPT.format("pyNN.spiNNaker"))
    with pytest.raises(SystemExit) as caught:
        main([*options, str(tmp_path / "script.py")])
    assert requires(str(caught.value.code), "nrp-spynnaker")
