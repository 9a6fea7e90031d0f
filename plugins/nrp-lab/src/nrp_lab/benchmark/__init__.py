"""A ladder of closed-loop tasks, by which backends are compared.

::

    tasks x brains x worlds x seeds ──sweeps──> rows ──scores, verdicts──> standings ──> table

Every task is a sweep in a folder of its own. Its verdict is that of ``nrp diff`` on the same runs.
"""

from nrp_core.utilities import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing takes 5 ms
if TYPE_CHECKING:
    from nrp_lab.benchmark.ladder import Ladder as Ladder
    from nrp_lab.benchmark.ladder import Standing as Standing
    from nrp_lab.benchmark.tasks import TASKS as TASKS
    from nrp_lab.benchmark.tasks import BenchmarkTask as BenchmarkTask
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
