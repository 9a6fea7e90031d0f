"""Experiments are found by name, file or folder, whatever their format."""

import os
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from nrp_lab.gym.env import NrpEnv
from nrp_lab.gym.vector import NrpVectorEnv

import nrp_core
from nrp_core.errors import BackendError, ExperimentError
from nrp_core.experiment.reading.find import find_file, load_experiment, shipped

PACKAGES = {"walkers": "", "broken": "import no_such_module"}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder, and a distribution that ships the experiments ``walkers`` and ``broken``."""
    site = tmp_path / "site"
    info = site / "walkers-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: walkers\nVersion: 1.0\n")
    entries = "".join(f"{name} = shipped_{name}\n" for name in PACKAGES)
    reader = "[nrp_core.experiment_readers]\n.walk = shipped_reader:read\n"
    (info / "entry_points.txt").write_text(f"[nrp_core.experiments]\n{entries}{reader}")
    (site / "shipped_reader.py").write_text(
        "def read(path, overrides=()): return path.stem, list(overrides)\n"
    )
    for name, source in PACKAGES.items():
        (site / f"shipped_{name}").mkdir()
        (site / f"shipped_{name}" / "__init__.py").write_text(source)
    for file in ("experiment.yaml", "slow.yaml", "notes.txt"):
        (site / "shipped_walkers" / file).touch()
    monkeypatch.syspath_prepend(site)
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    return here


def test_a_shipped_experiment_is_found_by_its_name_and_a_variant_by_both() -> None:
    assert find_file("walkers").parts[-2:] == ("shipped_walkers", "experiment.yaml")
    assert find_file("walkers/slow").parts[-2:] == ("shipped_walkers", "slow.yaml")


def test_a_distribution_ships_a_variant_of_an_experiment_of_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    site = tmp_path / "other"
    info = site / "runners-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: runners\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[nrp_core.experiments]\nwalkers/fast = shipped_runners\n")
    (site / "shipped_runners").mkdir()
    for file in ("__init__.py", "experiment.yaml"):
        (site / "shipped_runners" / file).touch()
    monkeypatch.syspath_prepend(site)
    assert find_file("walkers/fast").parts[-2:] == ("shipped_runners", "experiment.yaml")
    assert find_file("walkers/slow").parts[-2:] == ("shipped_walkers", "slow.yaml")
    assert "walkers/fast" in shipped()


def test_all_shipped_experiments_can_be_listed_though_one_is_broken() -> None:
    names = shipped()
    assert [name for name in names if name.startswith("walkers")] == ["walkers", "walkers/slow"]
    assert "braitenberg_husky" in names


def test_a_broken_package_is_reported_to_each_caller(golden: Golden) -> None:
    with golden.raises(BackendError, match=r"'broken'.*1\.0.*'no_such_module'"):
        find_file("broken")


def test_a_folder_with_the_name_of_a_shipped_experiment_needs_a_dot(folder: Path) -> None:
    (folder / "walkers").mkdir()
    (folder / "walkers" / "experiment.yaml").touch()
    assert find_file("walkers").parent.name == "shipped_walkers"
    assert find_file("./walkers") == folder / "walkers" / "experiment.yaml"


def test_a_folder_stands_for_its_experiment_yaml_or_its_only_experiment(folder: Path) -> None:
    (folder / "one.yaml").touch()
    (folder / "notes.txt").touch()
    assert find_file(".") == folder / "one.yaml"
    (folder / "experiment.yml").touch()
    assert find_file(str(folder)) == folder / "experiment.yml"


def test_a_folder_with_several_lists_them(folder: Path, golden: Golden) -> None:
    (folder / "one.yaml").write_text("extends: walkers\n")
    (folder / "two.walk").touch()
    with golden.raises(ExperimentError, match=r"one\.yaml, two\.walk"):
        find_file(".")


def test_a_repository_stands_for_the_experiment_below_it_or_lists_several(folder: Path) -> None:
    (folder / "_config.yml").write_text("theme: plain\n")
    (folder / "Experiments" / "one").mkdir(parents=True)
    (folder / ".hidden").mkdir()
    for name in ("Experiments/one/first.walk", "Experiments/one/room.yaml", ".hidden/other.walk"):
        (folder / name).touch()
    assert find_file(".") == folder / "Experiments" / "one" / "first.walk"
    (folder / "Experiments" / "two").mkdir()
    (folder / "Experiments" / "two" / "experiment.yaml").touch()
    listed = r"name one: Experiments/one/first\.walk, Experiments/two/experiment\.yaml$"
    with pytest.raises(ExperimentError, match=listed):
        find_file(".")


def test_a_folder_without_an_experiment_says_so(golden: Golden) -> None:
    with golden.raises(ExperimentError):
        find_file(".")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("walker", "'walker'.*'walkers'"),
        ("walkers/slwo", "'walkers/slwo'.*'walkers/slow'"),
        ("nothing.yaml", "'nothing.yaml'"),
        ("mine/circel.yaml", "'mine/circel.yaml'.*'mine/circle.yaml'"),
    ],
)
def test_an_unknown_name_gets_the_nearest_name_as_a_suggestion(
    text: str, message: str, folder: Path, golden: Golden
) -> None:
    (folder / "mine").mkdir()
    (folder / "mine" / "circle.yaml").touch()
    with golden.raises(ExperimentError, match=message):
        find_file(text)


def test_a_file_of_unknown_kind_is_refused(folder: Path, golden: Golden) -> None:
    (folder / "notes.txt").touch()
    with golden.raises(ExperimentError, match=r"\.walk"):
        find_file("notes.txt")


def test_the_reader_is_chosen_by_the_suffix_and_gets_the_overrides(folder: Path) -> None:
    (folder / "one.walk").touch()
    assert load_experiment("one.walk", ["seed=1"]) == ("one", ["seed=1"])


def test_a_path_that_is_not_text_is_refused(tmp_path: Path, golden: Golden) -> None:
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff"))
    folder.mkdir()
    (folder / "experiment.yaml").touch()
    with golden.raises(ExperimentError):
        find_file(str(folder))


@pytest.mark.parametrize("name", ["loop", "loop.yaml", "folder"])
def test_a_circle_of_symbolic_links_is_refused_with_its_name(
    tmp_path: Path, name: str, golden: Golden
) -> None:
    for link, target in (("loop", "loop"), ("loop.yaml", "loop.yaml"), ("folder/experiment.yaml", "nowhere")):
        (tmp_path / link).parent.mkdir(exist_ok=True)
        (tmp_path / link).symlink_to(target)
    with golden.raises(ExperimentError, match=" -> "):
        find_file(str(tmp_path / name))


@pytest.mark.parametrize("overrides", ["seed=3", {"seed": 3}])
def test_overrides_that_are_not_a_list_are_refused_as_a_whole(overrides: object, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        load_experiment("braitenberg_husky", overrides)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "begin",
    [nrp_core.run, partial(NrpEnv, observe=["/odom"]), partial(NrpVectorEnv, num_envs=2, observe=["/odom"])],
)
def test_overrides_of_one_key_that_are_given_together_are_refused(begin: Any, golden: Golden) -> None:
    with golden.raises(ExperimentError, match="'seed'.*'seed=1'.*'seed = 2'"):
        begin("braitenberg_husky", ["seed=1", "pace=max", "seed = 2"])


def test_a_recording_with_the_name_of_an_installed_experiment_is_not_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "slalom_pioneer").mkdir()
    for file in ("experiment.yaml", "run.json"):
        (tmp_path / "slalom_pioneer" / file).touch()
    find_file("slalom_pioneer")
    assert caplog.records == []


@pytest.mark.parametrize(
    ("name", "made", "is_told"),
    [
        ("slalom_pioneer", "slalom_pioneer/experiment.yaml", True),
        ("./slalom_pioneer", "slalom_pioneer/experiment.yaml", False),
        ("slalom_pioneer", "slalom_pioneer/recording.mcap", False),
        ("slalom_pioneer", "another/experiment.yaml", False),
    ],
)
def test_an_installed_experiment_with_the_name_of_a_local_folder_is_reported(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    name: str,
    made: str,
    is_told: bool,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / made).parent.mkdir()
    (tmp_path / made).write_text("name: mine\n")
    assert (find_file(name) == tmp_path / made) == name.startswith("./")
    told = [one.getMessage() for one in caplog.records]
    assert (
        told
        == ["'slalom_pioneer' is the installed experiment; the one in this folder is './slalom_pioneer'"]
        * is_told
    )
