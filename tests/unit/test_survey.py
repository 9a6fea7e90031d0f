"""Looking at installed backends, of which some do what none should."""

import os
import pickle
from collections.abc import Callable
from pathlib import Path

import pytest
from golden import Golden

from nrp_core._support import probe
from nrp_core.brain.backends import brains
from nrp_core.cli.survey import KINDS, Surveyed, examine, survey
from nrp_core.errors import BackendError

GOOD = """
from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.interface import BrainCapabilities
from nrp_core._support.diagnosis import Diagnosis

class Backend(BrainBackend):
    def capabilities(self, options):
        return BrainCapabilities(frozenset({"IF_curr_exp"}), frozenset({"static"}), resolution_ns=1000)
    def open(self, network, *, seed, options):
        raise NotImplementedError
"""
NEEDY = (
    GOOD
    + """
    def diagnose(self):
        return [Diagnosis("simulator 4", False, "is not installed", "pip install simulator", needed=True)]
"""
)

Install = Callable[[str, str], None]


@pytest.fixture
def install_brain(install: Callable[..., None]) -> Install:
    """Return a function that installs a brain backend of a name, with the source of its module."""

    def installed(name: str, source: str) -> None:
        install(name, f"[nrp_core.brain]\n{name} = {name}:Backend\n", source)

    return installed


def looked(name: str, *, timeout_s: float = 30.0) -> Surveyed:
    return examine("brain", brains().provider(name), timeout_s=timeout_s)


def test_a_backend_that_imports_lists_its_capabilities(install_brain: Install) -> None:
    install_brain("good", GOOD)
    found = looked("good")
    assert found.available
    assert (found.provider.distribution, found.provider.version) == ("good", "1.0")
    assert found.capabilities["cells"] == ["IF_curr_exp"]
    assert (found.capabilities["resolution_ns"], found.capabilities["determinism"]) == (1000, "machine")


def test_a_backend_whose_simulator_is_missing_is_not_available(install_brain: Install) -> None:
    install_brain("needy", NEEDY)
    found = looked("needy")
    assert not found.available
    assert found.advice == "simulator 4: is not installed; try: pip install simulator"


@pytest.mark.one_of(3)
@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("raise RuntimeError('no licence')", "RuntimeError: no licence"),
        ("import os; os._exit(7)", "ends the interpreter with exit code 7"),
        ("import os; os.abort()", "ends the interpreter: SIGABRT"),
        ("import ctypes; ctypes.string_at(0)", "ends the interpreter: SIGSEGV"),
        ("Backend = 5", "is not a subclass of BrainBackend"),
    ],
    ids=["raises", "exits", "aborts", "crashes", "no class"],
)
def test_a_backend_that_cannot_be_imported_is_reported_with_a_remedy(
    install_brain: Install, source: str, reason: str
) -> None:
    install_brain("bad", source)
    found = looked("bad")
    assert not found.available
    assert reason in found.reason
    assert "pip install" not in found.reason


@pytest.mark.one_of(2)
@pytest.mark.parametrize(
    ("source", "remedy"),
    [
        ("import not_installed_here", "pip install --force-reinstall bad"),
        ("from nrp_core.clock import no_such_name", "pip install --upgrade bad"),
        ("class Backend: pass", ""),
    ],
)
def test_the_command_that_helps_is_a_field_of_the_error(
    install_brain: Install, source: str, remedy: str
) -> None:
    install_brain("bad", source)
    with pytest.raises(BackendError) as raised:
        brains().load("bad")
    assert raised.value.remedy == remedy
    again = pickle.loads(pickle.dumps(raised.value))
    assert (again.reason, again.remedy, str(again)) == (raised.value.reason, remedy, str(raised.value))
    found = looked("bad")
    assert (found.reason, found.remedy) == (raised.value.reason, remedy)


def test_a_backend_that_takes_forever_is_given_up(install_brain: Install, golden: Golden) -> None:
    install_brain("slow", "import time; time.sleep(600)")
    found = looked("slow", timeout_s=0.3)
    assert not found.available
    golden(found.reason)


def test_one_broken_backend_does_not_hide_the_others(
    install_brain: Install, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(KINDS, "world")
    install_brain("bad", "import os; os.abort()")
    install_brain("good", GOOD)
    found = {one.provider.name: one.available for one in survey()}
    assert found["good"]
    assert not found["bad"]


def test_output_that_a_backend_prints_is_not_taken_as_its_answer(install_brain: Install) -> None:
    install_brain("chatty", "print('nrp-core survey: {}')\n" + GOOD + "\nprint('hello', end='')\n")
    assert looked("chatty").available


def test_two_distributions_with_one_name_are_both_refused(
    install_brain: Install, install: Callable[..., None]
) -> None:
    install_brain("good", GOOD)
    install("other", "[nrp_core.brain]\ngood = good:Backend\n")
    twice = [examine("brain", provider) for provider in brains().providers() if provider.name == "good"]
    assert [one.available for one in twice] == [False, False]
    assert all("two distributions provide the brain backend 'good'" in one.reason for one in twice)
    assert all(one.remedy.startswith("pip uninstall ") for one in twice)


def test_an_answer_is_kept_until_a_file_changes(
    install_brain: Install, site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install_brain("good", GOOD)
    first = looked("good")
    asked: list[object] = []

    def run(command: list[str], *_options: object) -> probe.ChildResult:
        asked.append(command)
        return probe.ChildResult(1)

    monkeypatch.setattr(probe, "_run", run)
    assert looked("good") == first
    assert not asked
    os.utime(site / "good.py", (1, 1))
    assert not looked("good").available
    assert len(asked) == 1
