"""A sweep in one call."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.extras import require_extra
from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.tree import tree_of
from nrp_core.paths import path_of
from nrp_lab.sweep.executors.interface import executor
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.reading import read_sweep, sweep_of
from nrp_lab.sweep.running import Choice, SweepRun, Tell
from nrp_lab.sweep.table import data_frame

if TYPE_CHECKING:
    import pandas as pd


def require_workers(workers: object) -> None:
    """Check the number of runs at once.

    Raises:
        ExperimentError: it is not a whole number from 1 on, or None.
    """
    if workers is not None and (not isinstance(workers, int) or isinstance(workers, bool) or workers < 1):
        raise ExperimentError(f"'workers' is a whole number, at least 1, not {workers!r:.60}")


@checks_arguments("description", "workers")
def sweep(
    description: str | Path | Mapping[str, Any],
    out: str | Path | None = None,
    *,
    on: str = "local",
    workers: int | None = None,
    only: Sequence[str] | str = (),
    retry_failed: bool = False,
    record: bool = False,
    confirmed: bool = False,
    tell: Tell = lambda _: None,
) -> pd.DataFrame:
    """Make the runs of a sweep and return their table, one row per run.

    What ``nrp validate`` says about the experiment is a Python warning before the first run.

    Example::

        table = sweep({"experiment": "slalom_pioneer", "vary": {"seed": {"from": 1, "to": 20}}})
        print(table["criteria.gets_through"].mean())

    Args:
        description: the file of the sweep, or its contents.
        out: the folder of the results; runs that it already holds are not repeated. By default temporary.
        on: ``local``, ``dask``, ``slurm`` or ``tcp://scheduler:8786``.
        workers: number of runs at once.
        only: conditions on the runs, ``key=value``, or their numbers, ``0..9``.
        retry_failed: whether to repeat the runs that failed.
        record: whether to keep a recording of every run, in ``out``.
        confirmed: whether more than 100 000 runs are allowed.
        tell: called after every run with the progress.

    Raises:
        ExperimentError: the sweep or the folder is not valid.
        BackendError: a requirement is not installed or cannot be reached.
    """
    require_workers(workers)
    require_extra("pandas", "nrp-lab[sweep]", "a table of a sweep in Python")
    if isinstance(description, Mapping):
        plan = Plan.of(sweep_of(tree_of(description)), confirmed=confirmed)
    else:
        file, source = read_sweep(path_of(description))
        plan = Plan.of(file, source, confirmed=confirmed)
    with TemporaryDirectory(prefix="nrp-sweep-") as temporary:
        folder = Path(temporary) if out is None else path_of(out)
        chosen = (only,) if isinstance(only, str) else tuple(only)
        made = SweepRun(plan, folder, Choice(chosen, retry_failed, record))
        if made.pending:
            plan.tell_doubts(partial(warnings.warn, stacklevel=4))
        with executor(on, folder, workers) as where:
            made.run(where, tell)
        return data_frame(made.rows)
