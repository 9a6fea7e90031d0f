"""A recording and the page that shows it in one HTML file, which needs no server."""
