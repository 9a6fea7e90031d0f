"""Networks in files: our own, which holds everything, and SONATA's, which others write."""

from __future__ import annotations

from nrp_core.brain.files.network_file import read_network, save_network

__all__ = ["read_network", "save_network"]
