"""Open or run an experiment in one call, with the warnings of the checks."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from math import inf
from pathlib import Path

from nrp_core._support.checked_arguments import checks_arguments, is_number, takes
from nrp_core._support.used_files import FilesRead
from nrp_core.checks.warnings import with_warnings
from nrp_core.clock import from_seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.making.plan import Plan, ProgressCallback, no_progress
from nrp_core.experiment.making.prepare import open_engine, prepare
from nrp_core.experiment.making.watch import declare_own
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment, once_each
from nrp_core.experiment.running.result import Result
from nrp_core.experiment.running.run import Run
from nrp_core.paths import path_of
from nrp_core.recording.folder.expected_size import size_note
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import Images, check_folder
from nrp_core.recording.recording import recorded
from nrp_core.world.world import World

_logger = logging.getLogger(__name__)


@checks_arguments("overrides")
def open_run(
    experiment: str | Path,
    overrides: Iterable[str] = (),
    *,
    until_s: float | None = None,
    progress: ProgressCallback = no_progress,
) -> Run:
    """Open a run whose problems include the warnings of ``nrp validate``.

    The checks use the parts of the run and execute nothing again. A :class:`~nrp_core.Run` of an experiment
    that was loaded is opened without them.

    Args:
        experiment: as for :func:`run`.
        overrides: as for :func:`run`.
        until_s: the end of the run, if it is not that of the experiment, s.
        progress: called with the name of each task as it begins.

    Raises:
        ExperimentError: the experiment does not exist, or it is wrong.
        BackendError: a backend is missing, broken or does not open.
    """
    return open_checked_run(load_experiment(experiment, once_each(overrides)), progress, until_s=until_s)


def open_checked_run(
    experiment: Experiment, progress: ProgressCallback = no_progress, *, until_s: float | None = None
) -> Run:
    """Open a run of an experiment that was loaded, with the warnings of the checks; see :func:`open_run`."""

    def checked(plan: Plan) -> Plan:
        progress("checking the experiment")
        return with_warnings(plan, until_s)

    return Run(experiment, progress, revise=checked)


@checks_arguments("overrides")
def open_world(experiment: str | Path | Experiment, overrides: Iterable[str] = ()) -> World:
    """Open the world of an experiment without its brain, with the topics and aliases of the experiment.

    Events, criteria and transfer functions do not act; the caller steps the world.

    Args:
        experiment: as for :func:`run`, or one that was loaded.
        overrides: as for :func:`run`.

    Raises:
        BackendError: a backend is missing, broken or does not open.
        InvalidExperimentError: the experiment is wrong; it carries all findings.
    """
    if not isinstance(experiment, Experiment):
        experiment = load_experiment(experiment, once_each(overrides))
    plan = prepare(experiment)
    world: World = open_engine(experiment.world, plan.world, plan.scene, experiment.seed)
    collector = Collector(experiment.source)
    try:
        declare_own(experiment, world, collector)
        collector.raise_errors()
    except BaseException:
        world.close()
        raise
    return world


@checks_arguments("overrides", "images", "snapshots_s", "on_step", "until_s")
def run(
    experiment: str | Path,
    overrides: Iterable[str] = (),
    *,
    until_s: float | None = None,
    record: str | Path | None = None,
    overwrite: bool = False,
    images: Images = Images.EXACT,
    snapshots_s: float | None = 10.0,
    on_step: Callable[[Run], None] | None = None,
) -> Result:
    """Run an experiment and return its result; CSV recorders write their files as with ``nrp run``.

    Example::

        result = run("braitenberg_husky", ["seed=3", "brain.backend=spinnaker"], until_s=5.0, record="out")
        assert result.complete and result.passed is not False

    Args:
        experiment: a shipped experiment (``name`` or ``name/variant``), a file, or a folder or ZIP archive
            with one.
        overrides: ``dotted.key=value``, as of ``nrp run --set``.
        until_s: simulated time at which to stop, s; by default the duration of the experiment.
        record: a new folder to record everything into.
        overwrite: whether to replace a recording in that folder, or existing files of CSV recorders.
        images: how a recording keeps camera images.
        snapshots_s: simulated time between two snapshots in a recording, s; None for none.
        on_step: called after every step with the run.

    Raises:
        ExperimentError: the experiment does not exist, it is wrong, ``record`` holds files already, or a file
            of a CSV recorder exists.
        BackendError: a backend is missing, broken or does not open.
        SimulationError: an engine, a transfer function or the disk failed; the recording up to there is kept.
    """
    folder = None if record is None else path_of(record)
    _require_options(images, snapshots_s, on_step)
    if folder is not None:
        check_folder(folder, overwrite=overwrite)
    with ExitStack() as stack:
        files = None if folder is None else stack.enter_context(FilesRead())
        simulation = stack.enter_context(open_run(experiment, overrides, until_s=until_s))
        if on_step is not None:
            simulation.on_step(on_step)
        if folder is None:
            simulation.check_csv(overwrite=overwrite)
            simulation.run(until_s)
            simulation.write_csv(overwrite=overwrite)
        else:
            note = size_note(simulation, until_s)
            if note is not None:
                _logger.warning("%s", note)
            snapshots_ns = None if snapshots_s is None else from_seconds(snapshots_s)
            capsule = RecordingFolder(
                simulation,
                folder,
                images=images,
                files=files,
                snapshots_ns=snapshots_ns,
                overwrite=overwrite,
            )
            _run_recorded(simulation, until_s, capsule)
        result = simulation.result()
        return result if folder is None else recorded(result, folder)


def _require_options(images: object, snapshots_s: object, on_step: object) -> None:
    """Check how to record before anything is opened.

    Raises:
        ExperimentError: an option is impossible.
    """
    if images not in [*Images]:
        raise ExperimentError(f"unknown image mode '{images}'{did_you_mean(str(images), Images)}")
    if snapshots_s is not None and not (is_number(snapshots_s) and 0.0 < snapshots_s < inf):
        raise ExperimentError(f"snapshots_s is a time above 0 in s, or None, not {snapshots_s!r:.60}")
    if on_step is not None and not callable(on_step):
        raise ExperimentError(f"on_step is a function of the run, not {on_step!r:.60}")
    if callable(on_step) and not takes(on_step, 1):
        raise ExperimentError("on_step is called with the run after every step: it takes one argument")


def _run_recorded(simulation: Run, until_s: float | None, capsule: RecordingFolder) -> None:
    state = "failed"
    try:
        simulation.run(until_s)
        state = "finished"
    except KeyboardInterrupt:
        state = "interrupted"
        raise
    finally:
        capsule.close(state)
