"""The cockpit: a run in the browser, live or recorded."""
