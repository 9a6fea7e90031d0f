"""``python -m hbp_nrp_virtual_coach SCRIPT [ARGUMENTS]``, as ``cle-virtual-coach`` on the platform."""

from __future__ import annotations

import argparse
import sys

from nrp_core.scripts import script_arguments


def main(arguments: list[str]) -> None:
    """Run a script with its arguments."""
    parser = argparse.ArgumentParser(
        "python -m hbp_nrp_virtual_coach",
        description="Run a script of the Virtual Coach, in Python 2 or 3, that uses rospy, messages of ROS, "
        "cv_bridge or tf. Scripts without these need only plain Python.",
    )
    _, script = script_arguments(parser, arguments)
    from hbp_nrp_virtual_coach.script import run_script

    run_script(script)


if __name__ == "__main__":
    main(sys.argv[1:])
