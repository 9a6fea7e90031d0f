"""Helpers for distributions that add commands, metrics, formats and executors.

They check arguments, write files, run worker processes and give names lazily. A name is imported when it is
first used.
"""

from nrp_core._support.lazy import lazily as _lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing would take 5 ms
if TYPE_CHECKING:
    from nrp_core._support.callables import takes as takes
    from nrp_core._support.checked_arguments import checks_arguments as checks_arguments
    from nrp_core._support.checked_arguments import require_fields as require_fields
    from nrp_core._support.extras import require_extra as require_extra
    from nrp_core._support.fingerprint import fingerprint as fingerprint
    from nrp_core._support.jit import jit as jit
    from nrp_core._support.jsonable import to_jsonable as to_jsonable
    from nrp_core._support.lazy import lazily as lazily
    from nrp_core._support.machine import cores as cores
    from nrp_core._support.named_values import Named as Named
    from nrp_core._support.stopwatch import work as work
    from nrp_core._support.strict_json import strict_json as strict_json
    from nrp_core._support.words import first_of as first_of
    from nrp_core._support.worker_pool import Worker as Worker
    from nrp_core._support.worker_pool import WorkerDiedError as WorkerDiedError
    from nrp_core._support.worker_pool import WorkerPool as WorkerPool
    from nrp_core._support.writing import writing as writing
else:
    __getattr__, __dir__, __all__ = _lazily(
        __name__,
        {
            "nrp_core._support.callables": "takes",
            "nrp_core._support.checked_arguments": "checks_arguments require_fields",
            "nrp_core._support.extras": "require_extra",
            "nrp_core._support.fingerprint": "fingerprint",
            "nrp_core._support.jit": "jit",
            "nrp_core._support.jsonable": "to_jsonable",
            "nrp_core._support.lazy": "lazily",
            "nrp_core._support.machine": "cores",
            "nrp_core._support.named_values": "Named",
            "nrp_core._support.stopwatch": "work",
            "nrp_core._support.strict_json": "strict_json",
            "nrp_core._support.words": "first_of",
            "nrp_core._support.worker_pool": "Worker WorkerDiedError WorkerPool",
            "nrp_core._support.writing": "writing",
        },
    )
