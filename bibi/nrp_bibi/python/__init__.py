"""Python as generated code needs it: syntax trees to text, laid out as ``ruff format`` would."""
