"""Many runs of one experiment with varying settings, on one machine or many.

::

    file ──axes, design──> plan ──tasks──> executor ──records──> journal ──> table ──> summary, figures

Every run is independent of the others, so its row of the table does not depend on when and where it ran.
"""

from nrp_core.utilities import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing takes 5 ms
if TYPE_CHECKING:
    from nrp_lab.sweep.executor import Executor as Executor
    from nrp_lab.sweep.record import Record as Record
    from nrp_lab.sweep.record import Task as Task
    from nrp_lab.sweep.running import sweep as sweep
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
