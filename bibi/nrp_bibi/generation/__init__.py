"""The transformation of models to Python."""
