"""Neurons of NESTML as cells in equations."""
