"""BIBI: transfer functions as models of building blocks, and their transformation to Python and back.

::

    model = read_bibi(Path("braitenberg.bibi"))
    print(generate(model, Path("braitenberg.bibi")))
"""

from nrp_bibi.generate.transformation import generate
from nrp_bibi.model.functions import Bibi
from nrp_bibi.reader import parse_bibi, read_bibi
from nrp_bibi.writer import bibi_text, write_bibi

__all__ = ["Bibi", "bibi_text", "generate", "parse_bibi", "read_bibi", "write_bibi"]
