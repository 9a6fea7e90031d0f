"""A session: a run that people watch and steer, or a recording that they look through."""
