"""A corpus of experiments in the styles of all times, and what runs one."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from nrp_legacy.reader import read_exc

from nrp_core.experiment.running.run import Run

CORPUS = Path(__file__).with_name("corpus")

Opened = Callable[..., Run]

ENGINES = {
    "event and mujoco": ("brain.backend=event", "world.backend=mujoco"),
    "spinnaker and pybullet": ("brain.backend=spinnaker", "world.backend=pybullet"),
}


@pytest.fixture
def corpus(tmp_path: Path) -> Path:
    """The corpus, in a folder that may be written to."""
    return Path(shutil.copytree(CORPUS, tmp_path / "corpus"))


@pytest.fixture
def opened(corpus: Path) -> Iterator[Opened]:
    """Opens an experiment of the corpus: ``opened("bare/bare.exc")``."""
    with ExitStack() as stack:

        def open_run(name: str, *overrides: str) -> Run:
            models = f"models=[{corpus / 'models'}]"
            return stack.enter_context(Run(read_exc(corpus / name, [models, *overrides])))

        yield open_run


@pytest.fixture
def written(tmp_path: Path) -> Callable[..., Path]:
    """Writes an experiment of a brain and transfer functions, without a robot; returns its ``.exc`` file."""

    def write(brain: str, functions: str, mode: str = "") -> Path:
        (tmp_path / "b.py").write_text(brain)
        (tmp_path / "tf.py").write_text(functions)
        parts = f'{mode}<brainModel><file>b.py</file></brainModel><transferFunction src="tf.py"/>'
        (tmp_path / "x.bibi").write_text(f"<bibi>{parts}</bibi>")
        path = tmp_path / "x.exc"
        path.write_text('<ExD><bibiConf src="x.bibi"/></ExD>')
        return path

    return write


@pytest.fixture(
    params=[
        pytest.param(pair, id=name, marks=pytest.mark.heavy if number else ())
        for number, (name, pair) in enumerate(ENGINES.items())
    ]
)
def played(request: pytest.FixtureRequest, opened: Opened) -> Callable[..., Run]:
    """Runs an experiment of the corpus to its end."""

    def play(name: str, *overrides: str) -> Run:
        run = opened(name, *request.param, *overrides)
        run.run()
        assert run.result().error is None
        return run

    return play
