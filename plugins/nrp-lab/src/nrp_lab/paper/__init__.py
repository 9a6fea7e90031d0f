"""An experiment as an archive that others can run again: recordings, figures, methods, verdict.

:func:`.archive.write_archive` makes it, :func:`.verification.verify_archive` repeats its runs.
"""
