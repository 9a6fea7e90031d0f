"""Selection of neurons by name, index and location."""
