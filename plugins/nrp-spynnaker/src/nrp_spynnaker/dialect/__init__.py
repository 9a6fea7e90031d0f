"""sPyNNaker's own additions to PyNN, so that its scripts run without a change.

``import pyNN.spiNNaker as sim`` and ``import spynnaker.pyNN as sim`` give a simulator that also has what
these scripts use beyond PyNN: names, settings of populations, cells, and helpers for data. It builds the same
:class:`~nrp_core.network.data.Network`. A class without an equivalent is refused by name, with the
reason.
"""

from nrp_spynnaker.dialect.modules import Dialect as Dialect
