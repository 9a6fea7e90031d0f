"""The start page shows each experiment: its own picture, or its scene, which is drawn once."""

from __future__ import annotations

import subprocess
from base64 import b64decode
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from golden import Golden
from nrp_cockpit.start.gallery import gallery
from nrp_cockpit.start.pictures import Pictures, picture_key

from nrp_core.errors import ExperimentError
from nrp_core.experiment.reading.find import load_experiment

SHORT = "extends: reaching_arm\nname: short\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with an experiment; nothing was drawn yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "short.yaml").write_text(SHORT)
    return tmp_path


def pixels_of(data: str) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(b64decode(data), np.uint8), cv2.IMREAD_COLOR)


@pytest.mark.heavy
def test_a_scene_is_drawn_once_for_all_experiments_that_look_the_same(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = str(folder / "short.yaml")
    key, pictures = picture_key(load_experiment(name)), Pictures()
    assert key == picture_key(load_experiment("reaching_arm"))
    assert key != picture_key(load_experiment("reflex_arm"))
    drawn = pictures.data(name, key)
    pixels = pixels_of(drawn["data"])
    assert (drawn["type"], pixels.shape) == ("image/jpeg", (270, 480, 3))
    assert len(np.unique(pixels[:, :, 2])) > 30  # not one colour, as of an empty image
    monkeypatch.setattr(subprocess, "Popen", None)
    assert Pictures().data("reaching_arm", key) == drawn


def test_an_experiment_shows_the_picture_in_its_folder(folder: Path) -> None:
    own = cv2.imencode(".png", np.full((4, 6, 3), 128, np.uint8))[1].tobytes()
    (folder / "any.png").write_bytes(own)
    name = str(folder / "short.yaml")
    found = Pictures().data(name, picture_key(load_experiment(name)))
    assert (found["type"], b64decode(found["data"])) == ("image/png", own)
    (folder / "other.png").write_bytes(own[::-1])  # which of them is meant?
    assert picture_key(load_experiment(name)) == picture_key(load_experiment("reaching_arm"))
    (folder / "short.png").write_bytes(own)
    assert picture_key(load_experiment(name)) != picture_key(load_experiment("reaching_arm"))


def test_a_scene_that_cannot_be_drawn_is_refused_and_nothing_is_kept(folder: Path, golden: Golden) -> None:
    pictures = Pictures()
    with golden.raises(ExperimentError):
        pictures._draw(str(folder / "none.yaml"), folder)
    pictures.close()
    with golden.raises(ExperimentError):
        pictures.data("reaching_arm", "0" * 32)
    assert not (folder / "cache/nrp-core/pictures" / ("0" * 32)).exists()


def test_the_page_knows_which_entries_have_a_picture(folder: Path) -> None:
    found = {entry.name: entry for entry in gallery(folder)}
    assert found["./short.yaml"].picture == found["reaching_arm"].picture != ""
    assert replace(found["./short.yaml"], picture="").error == ""
