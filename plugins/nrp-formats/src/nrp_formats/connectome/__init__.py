"""Connectomes: tables of edges and neurons, in CSV, Feather and Parquet, as a network."""
