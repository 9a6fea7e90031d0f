"""A ladder of small tasks, by which learners are compared.

::

    task x learner x seed ──trial──> training, test with frozen weights; baselines ──> table, learning curves

A task is a body in a world with quantities to observe, actions and rewards. A learner is a brain and its
transfer functions, in a file without a world.
"""

from nrp_core.utilities import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing takes 5 ms
if TYPE_CHECKING:
    from nrp_lab.learning.ladder import Ladder as Ladder
    from nrp_lab.learning.learner import Learner as Learner
    from nrp_lab.learning.learner import find_learner as find_learner
    from nrp_lab.learning.task import Task as Task
    from nrp_lab.learning.tasks import TASKS as TASKS
    from nrp_lab.learning.trial import Trial as Trial
    from nrp_lab.learning.trial import perform as perform
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
