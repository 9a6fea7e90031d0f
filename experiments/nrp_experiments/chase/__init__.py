"""Two robots that chase each other."""
