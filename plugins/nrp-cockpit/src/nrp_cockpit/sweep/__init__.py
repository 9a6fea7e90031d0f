"""The page of a sweep: its progress, tables and figures, from its folder."""
