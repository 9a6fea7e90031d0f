"""What this program runs on."""

import pytest
from packaging.requirements import Requirement

from nrp_core._support import machine
from nrp_core._support.diagnosis import Diagnosis


def test_a_machine_is_described_by_what_results_depend_on() -> None:
    described = machine.describe_machine()
    assert set(described) == {"platform", "architecture", "processor", "cpu_features", "cores", "python"}
    assert str(described["python"]).startswith("CPython 3.")


def test_every_installed_distribution_is_listed_with_its_version() -> None:
    assert machine.distributions()["numpy"].count(".") >= 1


def test_a_processor_without_avx_is_a_diagnosis(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "_cpuinfo", lambda: {"flags": "fpu sse4_2"})
    assert machine.describe_machine()["cpu_features"] == ["sse4_2"]
    found = {one.subject: one for one in machine.diagnose()}
    assert not found["AVX instructions"].present
    assert "illegal instruction" in found["AVX instructions"].meaning


def test_a_system_that_hides_its_instruction_set_gets_no_diagnosis_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(machine, "_cpuinfo", dict)
    assert "AVX instructions" not in {one.subject for one in machine.diagnose()}


def test_a_display_is_looked_for_in_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", ":0")
    assert machine._display().present
    monkeypatch.delenv("DISPLAY")
    assert machine._display() == Diagnosis("a display", False, "none; nothing here needs one")


def test_a_cache_that_cannot_be_written_is_a_diagnosis(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine.os, "access", lambda *_: False)
    (cache,) = (one for one in machine.diagnose() if one.subject.startswith("a cache folder"))
    assert not cache.present


@pytest.mark.parametrize(
    ("requirement", "present", "meaning"),
    [
        ("numpy>=1", True, ""),
        ("numpy>=99", False, "; nrp-core was written for >=99"),
        ("no-such-package>=3", False, "not installed"),
    ],
)
def test_a_package_that_is_missing_or_does_not_fit_has_a_remedy(
    requirement: str, present: bool, meaning: str
) -> None:
    found = machine._package(Requirement(requirement))
    assert found.present is present
    assert found.meaning.endswith(meaning)
    assert found.remedy == f"pip install '{requirement}'"
