"""Files changed at random are usable, or refused in clear words that name a file; nothing hangs."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import nrp_experiments.braitenberg_husky
import pytest
from mutations import Tally, mutated, numbered, numbers_in

from nrp_core.errors import ExperimentError, NrpError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.network.files import read_network, save_network
from nrp_core.network.files.script import load_network

SHIPPED = Path(nrp_experiments.braitenberg_husky.__path__[0])
CORPUS = Path(__file__).parents[2] / "plugins" / "nrp-legacy" / "tests" / "corpus"
SMALL = ("world.options.image_scale=0.05", "function_time_limit=2 s")
LONGEST_STEP_NS = 100_000_000


@dataclass(frozen=True)
class Case:
    """A kind of file.

    Args:
        file: which file is changed.
        experiment: which experiment uses it, in the same tree of files.
        overrides: what is else different about that.
        source: the tree of files.
    """

    file: str
    experiment: str = "experiment.yaml"
    overrides: Sequence[str] = ()
    source: Path = SHIPPED


MODELS = ("models=[{folder}/models]",)
CORPUS_AS_DRAWN = (*MODELS, "world.options.image_scale=1")
"""Its transfer functions look at the size of images."""
OLD = {"source": CORPUS, "overrides": MODELS}
CASES = {
    "experiment": Case("experiment.yaml"),
    "SDF robot": Case("husky.sdf"),
    "SDF room": Case("room.sdf"),
    "URDF": Case("cart.urdf", overrides=(
        "world.robots.husky.model={folder}/cart.urdf", "transfer_functions=null", "events=null",
        "criteria=null",
    )),
    "BIBI": Case("listing2.bibi", "bibi.yaml"),
    "transfer functions": Case("listing1.py"),
    "brain script": Case("brain.py"),
    "exc": Case("husky_2017/experiment_configuration.exc", "husky_2017/experiment_configuration.exc", **OLD),
    "old BIBI": Case("husky_2015/blocks.bibi", "husky_2015/ExDConf.exc", **OLD),
    "old transfer functions": Case("husky_2019/drive.py", "husky_2019/cart.exc", CORPUS_AS_DRAWN, CORPUS),
}  # fmt: skip


@pytest.mark.one_of(6)
@pytest.mark.parametrize("kind", CASES)
def test_a_mutated_file_is_usable_or_refused_in_clear_words(kind: str, tmp_path: Path) -> None:
    case = CASES[kind]
    folder = tmp_path / "files"
    shutil.copytree(case.source, folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(Path(__file__).parent / "files" / "cart.urdf", folder)
    overrides = [one.format(folder=folder) for one in case.overrides]
    path = folder / case.file
    sound = path.read_bytes()
    use(folder / case.experiment, overrides)
    tally = Tally(kind, lambda error: is_clear(error, folder))
    for number, random in numbered(kind):
        path.write_bytes(mutated(sound, random, text=True))
        tally.take(number, lambda: use(folder / case.experiment, overrides))
    tally.check()


def use(experiment: Path, overrides: Sequence[str]) -> None:
    """Run two steps on real engines; what comes out must be numbers."""
    loaded = load_experiment(str(experiment), [*SMALL, *overrides])
    if loaded.timestep > LONGEST_STEP_NS:
        return
    with Run(loaded) as run:
        for _ in range(2):
            run.step()
        result = run.result()
    assert all(map(isfinite, numbers_in(result.final_pose))), result.final_pose


def is_clear(error: NrpError, folder: Path) -> bool:
    """Whether an error names a file and has nothing of a traceback."""
    text = str(error)
    if isinstance(error, ExperimentError):
        return bool(error.message) and (error.path is not None or str(folder) in text or "override" in text)
    return bool(text) and "Traceback" not in text


def test_a_mutated_network_is_the_network_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "brain.nrpnet"
    network = load_network(SHIPPED / "brain.py", seed=7)
    save_network(network, path)
    sound = path.read_bytes()
    tally = Tally("network", lambda error: isinstance(error, ExperimentError) and error.path == path)

    def read() -> None:
        assert read_network(path).digest == network.digest

    for number, random in numbered("network"):
        path.write_bytes(mutated(sound, random, text=False))
        tally.take(number, read)
    tally.check()
