"""Networks in SONATA, an exchange format for large models.

Dai et al., PLoS Comput. Biol. 16(2):e1007696 (2020); the files are described in
https://github.com/AllenInstitute/sonata/blob/master/docs/SONATA_DEVELOPER_GUIDE.md
"""

from __future__ import annotations

from nrp_formats.sonata.circuit import read_sonata

__all__ = ["read_sonata"]
