"""Where the runs of a sweep are performed: one module each; others are added by entry points."""
