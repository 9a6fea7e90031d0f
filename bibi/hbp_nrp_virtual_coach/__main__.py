"""``python -m hbp_nrp_virtual_coach SCRIPT [ARGUMENTS]``, as ``cle-virtual-coach`` on the platform."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def main(arguments: list[str]) -> None:
    """Run a script with its arguments."""
    parser = argparse.ArgumentParser(
        "python -m hbp_nrp_virtual_coach",
        description="Run a script of the Virtual Coach, in Python 2 or 3, that uses rospy, messages of ROS, "
        "cv_bridge or tf. Scripts without these need only plain Python.",
    )
    parser.add_argument("script", metavar="SCRIPT")
    parser.add_argument("arguments", metavar="ARGUMENTS", nargs=argparse.REMAINDER)
    given = parser.parse_args(arguments)
    script = Path(given.script)
    if not script.is_file():
        parser.error(f"there is no file {given.script}")
    sys.argv = [given.script, *given.arguments]
    from hbp_nrp_virtual_coach.script import run_script

    run_script(script.resolve())


if __name__ == "__main__":
    main(sys.argv[1:])
