"""Settings of all tests of the cockpit."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("untimed", deadline=None)  # machines are busy at times; no test is timed
settings.load_profile("untimed")
