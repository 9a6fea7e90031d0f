"""The cost of starting: imports in fresh interpreters, over a bare one. CPU time, best of several runs.

python benchmarks/startup.py [REPEATS]
"""

from __future__ import annotations

import resource
import subprocess
import sys

from conditions import print_conditions

LIMIT_MS = 30.0
STARTS = {
    "import nrp_core": LIMIT_MS,
    "import nrp_core.brain, nrp_core.world": LIMIT_MS,
    "from nrp_core import run": None,
    "import sys; sys.argv = ['nrp', '--help']; sys.stdout = open('/dev/null', 'w'); "
    "from nrp_core.cli import main; main()": 200.0,
}


def best_ms(code: str, repeats: int) -> float:
    times = []
    for _ in range(repeats):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", code], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times) * 1e3


def main() -> None:
    print_conditions()
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    bare_ms = best_ms("pass", repeats)
    print(f"a bare interpreter: {bare_ms:.1f} ms; over it:")
    for code, limit_ms in STARTS.items():
        over_ms = best_ms(code, repeats) - bare_ms
        limit = (
            ""
            if limit_ms is None
            else f" (limit {limit_ms:g} ms{', exceeded' if over_ms > limit_ms else ''})"
        )
        print(f"  {over_ms:6.1f} ms  {code[:60]}{limit}")


if __name__ == "__main__":
    main()
