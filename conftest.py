"""Options of the whole test suite."""

import gc
import json
import os
import signal
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import platformdirs
import pytest

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job in the background ignores Ctrl-C

# where kernels are kept anyway: tests with a cache folder of their own would compile all of them again
os.environ.setdefault("NUMBA_CACHE_DIR", str(platformdirs.user_cache_path("nrp-core") / "kernels"))
# and where Matplotlib keeps its list of fonts, which takes it seconds to make
os.environ.setdefault("MPLCONFIGDIR", str(platformdirs.user_cache_path("matplotlib")))


@pytest.fixture(scope="session")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of the commands ``python`` and ``nrp`` that run in forks, which start sooner."""
    from warm import programs  # not when ``nrp conformance`` reads this file

    with programs(tmp_path_factory.mktemp("warm")) as folder:
        yield folder


@pytest.hookimpl(wrapper=True)
def pytest_sessionfinish(session: pytest.Session) -> Iterator[None]:
    """Keep what the tests of each file took, by which ``scripts/test --changed`` chooses among them."""
    file = Path(__file__).parent / ".venv" / "test_seconds.json"
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    taken: Counter[str] = Counter()
    for report in () if reporter is None else (each for kind in reporter.stats.values() for each in kind):
        if isinstance(report, pytest.TestReport):
            taken[report.nodeid.partition("::")[0]] += report.duration
    if taken and file.parent.is_dir() and not hasattr(session.config, "workerinput"):
        known: dict[str, float] = {}
        with suppress(OSError, ValueError):  # there is none, or two runs wrote it at once
            known = json.loads(file.read_text())
        text = json.dumps(known | {name: round(time_s, 2) for name, time_s in taken.items()})
        (part := file.with_suffix(f".{os.getpid()}")).write_text(text)
        part.replace(file)
    return (yield)


def pytest_addoption(parser: pytest.Parser, pluginmanager: pytest.PytestPluginManager) -> None:
    parser.addoption(
        "--oracle", action="append", default=[], type=Path, metavar="FILE",
        help="check this file of references as well (.npz: event, .json: spinnaker); repeatable",
    )  # fmt: skip
    try:
        import cases
        import golden
        import without_pybullet
    except ModuleNotFoundError:  # ``nrp conformance`` reads this file without the folders of the tests
        return
    pluginmanager.register(cases)
    pluginmanager.register(golden)
    pluginmanager.register(without_pybullet)


@pytest.hookimpl(tryfirst=True)
def pytest_collection() -> None:
    """Do not look for garbage while thousands of tests are collected, which all stay."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Leave the tests themselves out of the garbage collection, which would look through them each time."""
    gc.enable()
    gc.collect()
    gc.freeze()
