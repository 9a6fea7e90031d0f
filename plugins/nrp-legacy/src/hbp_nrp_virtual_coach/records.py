"""What a simulation records: the rows of its functions, and whole recordings."""

from __future__ import annotations

import csv
import shutil
from contextlib import suppress
from io import StringIO
from pathlib import Path

from hbp_nrp_virtual_coach.live import Live
from hbp_nrp_virtual_coach.settings import say_once
from nrp_core.errors import ExperimentError, LifecycleError, did_you_mean
from nrp_core.experiment import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder

RECORDINGS = "recordings"


class Records(Live):
    """The part of a simulation that deals with records."""

    _recording: RecordingFolder | None = None
    _folder: Path | None = None

    def save_csv(self) -> None:
        """Write the data of CSV recorders so far to the files of this run."""
        try:
            self._runner.call(lambda run: run.write_csv(self._records, overwrite=True))
        except LifecycleError:  # all is written when a simulation ends
            self._runner.wait()

    def print_csv_file_names(self) -> None:
        """Print the names of the CSV files of this run."""
        self.save_csv()
        for name in csv_names(self._records):
            print(name)

    def get_csv_data(self, name: str) -> list[list[str]]:
        """Return the rows that have been recorded for a CSV file, the headers first.

        Raises:
            ExperimentError: the file does not exist.
        """
        return list(csv.reader(StringIO(self.get_csv_last_run_file(name))))

    def get_csv_last_run_file(self, file_name: str) -> str:
        """Return the text of a CSV file, with all that has been recorded.

        Raises:
            ExperimentError: the file does not exist.
        """
        self.save_csv()
        return csv_contents(self._records, file_name).decode()

    def start_recording(self) -> None:
        """Record the run from now on.

        Raises:
            LifecycleError: it is being recorded already.
        """
        self._runner.call(self._begin)

    def pause_recording(self) -> None:
        """Do nothing: a recording has no pauses."""
        say_once("a recording cannot be paused: it goes on")

    def unpause_recording(self) -> None:
        """Do nothing: a recording is never paused."""

    def stop_recording(self, save: bool, description: str | None = None) -> Path | None:
        """End the recording.

        Args:
            save: whether to keep it; its folder is returned then.
            description: a text that is kept in it, as ``description.txt``.

        Raises:
            LifecycleError: the run is not being recorded.
        """
        folder = self._runner.call(lambda _run: self._complete("interrupted"))
        if folder is None:
            raise LifecycleError("the simulation is not being recorded")
        if not save:
            shutil.rmtree(folder)
            return None
        if description is not None:
            (folder / "description.txt").write_text(description, encoding="utf-8")
        return folder

    def _begin(self, run: Run) -> None:
        if self._recording is not None:
            raise LifecycleError("the simulation is being recorded already")
        recordings = self._records / RECORDINGS
        recordings.mkdir(parents=True, exist_ok=True)
        self._folder = recordings / str(len(list(recordings.iterdir())))
        self._recording = RecordingFolder(run, self._folder, files=self._runner.files)

    def _complete(self, state: str) -> Path | None:
        recording, self._recording = self._recording, None
        if recording is None:
            return None
        recording.close(state)
        return self._folder

    def _finish(self, run: Run) -> None:
        self._complete("failed" if run.error else "finished")
        super()._finish(run)
        with suppress(OSError):  # it holds files
            self._records.rmdir()


def csv_names(folder: Path) -> list[str]:
    """Return the names of the CSV files of a run."""
    return sorted(path.name for path in folder.glob("*.csv"))


def csv_contents(folder: Path, name: str) -> bytes:
    """Return the contents of a CSV file of a run.

    Raises:
        ExperimentError: the file does not exist.
    """
    names = csv_names(folder)
    if name not in names:
        raise ExperimentError(
            f"the run does not have a file '{name}'{did_you_mean(name, names)}", subject=name
        )
    return (folder / name).read_bytes()
