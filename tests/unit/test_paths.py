"""Files that files name."""

from pathlib import Path

import pytest
from golden import Golden
from pydantic import BaseModel, ValidationError

from nrp_core.paths import ExistingFile, MissingFileError, TextFrom, existing_file


class Options(BaseModel):
    model: ExistingFile


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "brain.py").touch()
    (tmp_path / "room.sdf").touch()
    (tmp_path / ".gitignore").touch()
    (tmp_path / "sub").mkdir()
    return tmp_path


def test_a_relative_path_starts_at_the_folder_of_the_file_that_names_it(folder: Path) -> None:
    assert existing_file(TextFrom.of("brain.py", folder)) == folder / "brain.py"
    assert existing_file(TextFrom.of("../brain.py", folder / "sub")) == folder / "brain.py"


def test_without_such_a_file_it_starts_at_the_current_folder(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    assert existing_file("brain.py") == folder / "brain.py"


def test_an_absolute_path_and_the_home_folder_stay_unchanged(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(folder))
    assert existing_file(TextFrom.of(str(folder / "brain.py"), Path("/"))) == folder / "brain.py"
    assert existing_file(TextFrom.of("~/brain.py", Path("/"))) == folder / "brain.py"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("brian.py", r"'brian\.py'.*'brain\.py'"),
        ("walker.urdf", r"'walker\.urdf'.*brain\.py, room\.sdf$"),
        (".gitignor", r"'\.gitignor'.*'\.gitignore'"),
        ("sub", "'sub'"),
        ("no/brain.py", r"'no/brain\.py'.*/no"),
    ],
)
def test_a_missing_file_gets_the_nearest_one_beside_it(
    folder: Path, name: str, message: str, golden: Golden
) -> None:
    with golden.raises(MissingFileError, match=message):
        existing_file(TextFrom.of(name, folder))


def test_a_value_that_is_not_text_does_not_name_a_file(golden: Golden) -> None:
    with golden.raises(ValueError):
        existing_file(3)


def test_options_of_third_parties_use_it_too(folder: Path, golden: Golden) -> None:
    assert Options.model_validate({"model": TextFrom.of("brain.py", folder)}).model == folder / "brain.py"
    with golden.raises(ValidationError):
        Options.model_validate({"model": TextFrom.of("brian.py", folder)})
