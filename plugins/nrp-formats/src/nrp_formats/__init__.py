"""Networks and recordings in the files of other programs: NIR, SONATA, tables of connectomes, NWB.

An experiment names a file ``.nir`` or ``.json`` as its brain. A brain script builds a part of its network
from one::

    from nrp_formats import load_nir

    sim.setup(timestep=0.1)
    cells = load_nir(sim, "net.nir", method="euler")
"""

from nrp_core.utilities import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from nrp_formats.connectome.network import read_connectome as read_connectome
    from nrp_formats.nir.load import load_nir as load_nir
    from nrp_formats.nir.load import read_nir as read_nir
    from nrp_formats.nir.save import save_nir as save_nir
    from nrp_formats.sonata.circuit import read_sonata as read_sonata
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
