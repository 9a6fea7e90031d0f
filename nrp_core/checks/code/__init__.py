"""Python code of an experiment as it is written: what it declares and does, found without executing it."""
