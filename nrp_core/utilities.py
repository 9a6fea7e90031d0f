"""Helpers for distributions that add commands, metrics, formats and executors.

They check arguments, write files, run worker processes and give names lazily. A name is imported when it is
first used.
"""

from nrp_core._support.lazy import lazily as _lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing would take 5 ms
if TYPE_CHECKING:
    from nrp_core._support import time_limit as time_limit
    from nrp_core._support.cache import cached_folder as cached_folder
    from nrp_core._support.checked_arguments import checks_arguments as checks_arguments
    from nrp_core._support.checked_arguments import require_fields as require_fields
    from nrp_core._support.checked_arguments import takes as takes
    from nrp_core._support.files import replace_file as replace_file
    from nrp_core._support.files import replacing as replacing
    from nrp_core._support.files import writing as writing
    from nrp_core._support.hdf5 import new_file as new_file
    from nrp_core._support.jit import jit as jit
    from nrp_core._support.json_values import strict_json as strict_json
    from nrp_core._support.json_values import to_jsonable as to_jsonable
    from nrp_core._support.lazy import lazily as lazily
    from nrp_core._support.machine import cores as cores
    from nrp_core._support.machine import describe_machine as describe_machine
    from nrp_core._support.named_values import Named as Named
    from nrp_core._support.packages import fingerprint as fingerprint
    from nrp_core._support.packages import require_extra as require_extra
    from nrp_core._support.stopwatch import work as work
    from nrp_core._support.text import join_with_limit as join_with_limit
    from nrp_core._support.worker_pool import Worker as Worker
    from nrp_core._support.worker_pool import WorkerDiedError as WorkerDiedError
    from nrp_core._support.worker_pool import WorkerPool as WorkerPool
else:
    __getattr__, __dir__, __all__ = _lazily(__name__)
