"""Events and criteria of a running experiment."""
