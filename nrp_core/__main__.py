"""``python -m nrp_core`` is ``nrp``."""

from nrp_core.cli import main

if __name__ == "__main__":
    main()
