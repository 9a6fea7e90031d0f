"""A session: a run that users watch and control, or a recording that they play."""
