"""A comparison for readers: as text, as one HTML page, as JSON."""
