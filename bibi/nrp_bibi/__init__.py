"""BIBI: transfer functions as models of building blocks, and their transformation to Python and back.

::

    model = read_bibi(Path("braitenberg.bibi"))
    print(generate(model, Path("braitenberg.bibi")))

Each name is imported when it is first used, so that ``nrp --help`` stays quick.
"""

from nrp_core._support.lazy import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing would take 5 ms
if TYPE_CHECKING:
    from nrp_bibi.generation.transformation import generate as generate
    from nrp_bibi.model.functions import Bibi as Bibi
    from nrp_bibi.reader import parse_bibi as parse_bibi
    from nrp_bibi.reader import read_bibi as read_bibi
    from nrp_bibi.writer import bibi_text as bibi_text
    from nrp_bibi.writer import write_bibi as write_bibi

__getattr__, __dir__, __all__ = lazily(__name__)
