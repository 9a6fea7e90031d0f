"""``python -m nrp_client SCRIPT``: run a script that steers NRP-core 4."""

from __future__ import annotations

import argparse
import sys

from nrp_ebrains.modules import scope_with

from nrp_core.errors import ExperimentError, NrpError
from nrp_core.scripts import script_arguments


def main() -> None:
    """Run the script; names of ``nrp_core`` and ``nrp_protobuf`` in it are those of NRP-core 4."""
    parser = argparse.ArgumentParser(prog="python -m nrp_client", description="Run a client script.")
    _, script = script_arguments(parser, sys.argv[1:])
    scope = scope_with({}, {})
    try:
        scope.run(script, name="__main__")
    except NrpError as error:
        sys.exit(f"error: {scope.located(error, ExperimentError, script)}")


if __name__ == "__main__":
    main()
