"""The pytest plugin behind ``nrp conformance``: ``pytest -p nrp_conformance.plugin --prove JSON ...``.

It runs in a process of its own, because a backend under test may crash its process.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from nrp_conformance.proof import Proof
from nrp_conformance.run import ResultCollector, under_test
from nrp_core.errors import NrpError


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options for the backend under test and the report."""
    group = parser.getgroup("nrp conformance")
    group.addoption("--prove", type=lambda text: Proof(**json.loads(text)), help="kind, name, options, level")
    group.addoption("--write", type=Path, help="the file for the report")


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> pytest.ExitCode | None:
    """Run nothing if the backend or its options cannot be used; the caller reports the reason."""
    proof: Proof = config.getoption("--prove")
    try:
        proof.report([])
    except NrpError as error:
        _write(config, {"refused": str(error)})
        return pytest.ExitCode.USAGE_ERROR
    return None


def pytest_configure(config: pytest.Config) -> None:
    """Choose the suite."""
    proof: Proof = config.getoption("--prove")
    under_test.append(proof.tests)
    config.pluginmanager.register(ResultCollector(), "nrp-conformance-results")


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write the report."""
    collector = session.config.pluginmanager.get_plugin("nrp-conformance-results")
    assert isinstance(collector, ResultCollector)
    proof: Proof = session.config.getoption("--prove")
    _write(session.config, proof.report(collector.results).to_dict())


def _write(config: pytest.Config, data: object) -> None:
    file: Path = config.getoption("--write")
    file.write_text(json.dumps(data, indent=2, ensure_ascii=False) + "\n", "utf-8")
