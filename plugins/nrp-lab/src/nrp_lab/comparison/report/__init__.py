"""Reports of a comparison: as text, as one HTML page, as JSON."""
