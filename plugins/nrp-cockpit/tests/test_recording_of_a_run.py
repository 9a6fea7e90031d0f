"""A recording that begins in the cockpit."""

from pathlib import Path

from nrp_cockpit.command import open_run
from nrp_cockpit.wire.hub import Hub

from nrp_core.recording import Recording, Replay, ReplayRequest


def test_it_keeps_the_files_that_the_room_includes_and_can_be_replayed(tmp_path: Path) -> None:
    with open_run("braitenberg_husky", ["world.options.image_scale=0.1"], Hub()) as session:
        session.run.step()
        session.record(str(tmp_path / "run"))  # type: ignore[attr-defined]
        for _ in range(3):
            session.run.step()
        session.record(None)  # type: ignore[attr-defined]
        session.close()
        session.serve()  # ends at once, and closes what the session holds
    assert (tmp_path / "run" / "experiment" / "screen.sdf").is_file()
    with Replay(Recording(tmp_path / "run"), ReplayRequest()) as again:
        outcome = again.verify()
    assert (outcome.difference, outcome.steps) == (None, 3)
