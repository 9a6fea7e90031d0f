"""Devices as transfer functions see them."""
