"""Networks in files: this project's own format, which is complete, and SONATA."""

from __future__ import annotations

from nrp_core.network.files.network_file import read_network, save_network

__all__ = ["read_network", "save_network"]
