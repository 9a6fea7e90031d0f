"""Which code runs, told by its files."""

import shutil
from pathlib import Path

import pytest

from nrp_core._support.packages import fingerprint


@pytest.fixture
def package(site: Path) -> Path:
    """A package of two modules and some data."""
    folder = site / "tool"
    (folder / "inner").mkdir(parents=True)
    for name, text in (("__init__.py", ""), ("inner/deep.py", "x = 1\n"), ("data.txt", "5")):
        (folder / name).write_text(text)
    return folder


@pytest.fixture(autouse=True)
def _each_time_anew() -> None:
    fingerprint.cache_clear()


def taken(package: str = "tool") -> str:
    fingerprint.cache_clear()  # as in another process
    return fingerprint(package)


def test_it_changes_with_the_code_and_with_nothing_else(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = taken()
    assert len(first) == 16
    (package / "data.txt").write_text("6")
    (package / "__pycache__").mkdir()
    (package / "__pycache__" / "deep.pyc").write_bytes(b"7")
    assert taken() == first
    deep = package / "inner" / "deep.py"
    deep.write_text("x = 2\n")
    other = taken()
    assert other != first
    deep.rename(package / "deep.py")
    assert taken() not in (first, other)
    (package / "deep.py").rename(deep)
    shutil.move(package, tmp_path / "elsewhere" / "tool")
    monkeypatch.syspath_prepend(tmp_path / "elsewhere")
    assert taken() == other


def test_a_module_by_itself_has_one(site: Path) -> None:
    (site / "single.py").write_text("x = 1\n")
    first = taken("single")
    (site / "single.py").write_text("x = 2\n")
    assert "" != first != taken("single")


@pytest.mark.parametrize("name", ["sys", "no_such_package", "__main__"])
def test_a_folder_without_files_has_an_empty_fingerprint(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.modules", {"__main__": type(pytest)("__main__")})
    assert taken(name) == ""


def test_it_is_taken_once_a_process(package: Path) -> None:
    first = fingerprint("tool")
    (package / "__init__.py").write_text("y = 1\n")
    assert fingerprint("tool") == first
