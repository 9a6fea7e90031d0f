"""The start page of a folder of traps executes nothing, except by the request that opens an experiment."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import traps
from nrp_cockpit.start.session import StartSession
from nrp_cockpit.wire.hub import Hub

from nrp_core.errors import NrpError

EXECUTED = {"/cockpit/start/open": True, "/cockpit/start/look": False, "/cockpit/start/picture": False}
"""Whether a request of the start page executes what it names; once opened, an experiment runs."""


@pytest.fixture
def marks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder of marks; the current one has all traps."""
    folder, marks = tmp_path / "stranger", tmp_path / "marks"
    folder.mkdir()
    marks.mkdir()
    monkeypatch.setenv(traps.MARKS, str(marks))
    traps.lay(folder)
    monkeypatch.chdir(folder)
    return marks


def test_every_request_of_the_start_page_is_in_the_table() -> None:
    hub = Hub()
    session = StartSession(hub, lambda *_: pytest.fail("nothing is opened"))
    assert {*hub.constant.steering, *hub.constant.watching} == EXECUTED.keys()
    session.close()


def test_a_page_that_shows_and_draws_a_folder_of_traps_springs_none(marks: Path) -> None:
    session = StartSession(Hub(), lambda *_: pytest.fail("nothing is opened"), Path())
    session.look()
    assert "./experiment.yaml" in session._entries
    drawn = 0
    for name, entry in session._entries.items():
        if entry.installed:
            continue
        try:
            session.picture(name, reads_files=True)
            drawn += 1
        except NrpError:
            pass
    session.close()
    assert drawn > 0
    assert list(marks.iterdir()) == []
