"""Turn syntax trees into text, formatted as ``ruff format`` would."""
