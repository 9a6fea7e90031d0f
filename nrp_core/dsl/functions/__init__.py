"""Transfer functions and the decorators that make them."""
