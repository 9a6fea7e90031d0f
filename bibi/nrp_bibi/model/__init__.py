"""The metamodel: every element of a BIBI document as a class."""
