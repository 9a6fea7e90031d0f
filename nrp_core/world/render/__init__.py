"""Images: their definition for all renderers, and a renderer without an engine or a graphics library."""
