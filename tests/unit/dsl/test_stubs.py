"""The types that editors see for ROS messages are those of the classes that functions get."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from nrp_core.dsl.messages import message_packages, service_packages

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def generated() -> dict[str, str]:
    """What the script would write."""
    files: dict[str, str] = runpy.run_path(str(ROOT / "scripts" / "generate_stubs.py"))["files"]()
    return files


def test_the_stubs_equal_the_output_of_their_script(generated: dict[str, str]) -> None:
    stubs = ROOT / "stubs"
    written = {str(path.relative_to(stubs)): path.read_text() for path in stubs.rglob("*") if path.is_file()}
    assert written == generated, "run scripts/generate_stubs.py"


def test_every_package_that_functions_import_has_types(generated: dict[str, str]) -> None:
    for name in message_packages():
        assert f"{name}-stubs/msg.pyi" in generated
    for name in service_packages():
        assert f"{name}-stubs/srv.pyi" in generated


def test_every_message_stands_in_the_stub_of_its_package(generated: dict[str, str]) -> None:
    for name, package in message_packages().items():
        stub = generated[f"{name}-stubs/msg.pyi"]
        for kind in (label for label in dir(package.msg) if not label.startswith("_")):
            assert f" as {kind}\n" in stub or f"class {kind}:" in stub, f"{name}.msg.{kind}"


def test_every_stub_ships_and_is_never_imported() -> None:
    project = (ROOT / "pyproject.toml").read_text()
    for folder in (ROOT / "stubs").iterdir():
        assert f'"stubs/{folder.name}"' in project
        assert folder.name.endswith("-stubs"), "a name that cannot be imported"
