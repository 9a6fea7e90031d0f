"""How experiments are found and read."""
