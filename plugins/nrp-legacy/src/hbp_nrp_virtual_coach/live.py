"""A simulation in the background, as the base of the interface for scripts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import Any, ClassVar

from nrp_legacy.maker import ShimmedMaker

from hbp_nrp_virtual_coach.runner import Runner
from hbp_nrp_virtual_coach.settings import log
from hbp_nrp_virtual_coach.storage import Stored
from nrp_core.errors import ExperimentError
from nrp_core.experiment import Experiment, Run


class Live:
    """An experiment that runs in the background.

    Args:
        stored: its folder.
        read: reads the experiment anew.

    Attributes:
        on_launch: called with the run of each simulation of this process when it is open.

    Raises:
        NrpError: it cannot be opened.
    """

    on_launch: ClassVar[list[Callable[[Run], None]]] = []

    def __init__(self, stored: Stored, read: Callable[[], Experiment]) -> None:
        self._stored, self._read = stored, read
        self._callbacks: list[Callable[[dict[str, Any]], object]] = []
        self._drafts = TemporaryDirectory(prefix="virtual_coach_")
        self._runner = Runner(read, self._tell, self._finish, self._launched)
        self._records = stored.new_run()

    def start(self) -> None:
        """Start or resume the simulation, and return at once.

        Raises:
            LifecycleError: it is stopped, or was halted by an error.
        """
        self._runner.start()

    def pause(self) -> None:
        """Pause the simulation after the current step.

        Raises:
            LifecycleError: it is stopped.
        """
        self._runner.pause()

    def stop(self) -> None:
        """End the simulation, write its CSV files, and release it."""
        self._runner.stop()
        self._drafts.cleanup()

    def get_state(self) -> str:
        """Return ``paused``, ``started``, ``stopped``, or ``halted`` after an error."""
        return self._runner.poll()

    def register_status_callback(self, callback: Callable[[dict[str, Any]], object]) -> None:
        """Have a function called with the status, a dict.

        It holds ``simulationTime`` and ``realTime`` (s), ``state``, and ``timeout``, the simulated time that
        is left (s). The function is called at every whole second of simulated time, when the state changes,
        and at least once a second. The simulation waits until it returns, so pausing there is exact.

        Raises:
            ExperimentError: it cannot be called.
        """
        if not callable(callback):
            raise ExperimentError(f"a status callback is a function, not {callback!r}")
        self._callbacks.append(callback)

    def _tell(self, status: dict[str, Any]) -> None:
        for callback in list(self._callbacks):
            try:
                callback(status)
            except Exception:  # noqa: BLE001 - the simulation outlives whatever users write
                log.exception("a status callback failed")

    def _launched(self, run: Run) -> None:
        if isinstance(run.experiment.maker, ShimmedMaker):
            run.experiment.maker.names.graph.on_end.append(lambda: self._runner.end())
        for observer in self.on_launch:
            observer(run)

    def _finish(self, run: Run) -> None:
        """Keep the recording of the run before it is closed."""
        run.write_csv(self._records, overwrite=True)  # a changed brain makes another run

    def _draft(self, name: str, source: str) -> Path:
        """Write a source to a file, for the run to read.

        Raises:
            ExperimentError: it is the name of a file.
        """
        if source.strip().endswith(Path(name).suffix) and len(source.split()) == 1:
            raise ExperimentError(
                f"{source.strip()!r:.60} is the name of a file; give its text, open(...).read()"
            )
        path = Path(mkdtemp(dir=self._drafts.name), name)
        path.write_text(source, encoding="utf-8")
        return path

    def _is_draft(self, path: Path) -> bool:
        return Path(self._drafts.name) in path.parents

    def _save(self, path: Path, source: str) -> None:
        """Write a source into the files of the experiment.

        Raises:
            ExperimentError: these are not the user's.
        """
        home = self._stored.file.parent.resolve()
        if not self._stored.is_own or home not in path.resolve().parents:
            raise ExperimentError(
                "is not saved: the file does not belong to an experiment of yours", path=path
            )
        path.write_text(source, encoding="utf-8")
