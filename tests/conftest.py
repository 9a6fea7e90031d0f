"""Options of the whole test suite."""

import signal
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("untimed", deadline=None)  # machines are busy at times; no test is timed
settings.load_profile("untimed")
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job in the background ignores Ctrl-C


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--oracle", action="append", default=[], type=Path, metavar="FILE",
        help="check this file of references as well (.npz: event, .json: spinnaker); repeatable",
    )  # fmt: skip
