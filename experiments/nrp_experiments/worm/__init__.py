"""The connectome of the adult hermaphrodite of *C. elegans*: 302 neurons and their chemical synapses.

``edges.csv`` has the sections in which synapses are seen (Cook et al. 2019, doi:10.1038/s41586-019-1352-7).
OpenWorm publishes them in cect 0.3.5 (https://pypi.org/project/cect/) under the MIT licence in ``LICENSE``;
the supplement of the article states none. ``neurons.csv`` names the 26 neurons with GABA of McIntire et al.
(1993), Nature 364:337. :mod:`.tables` made both.
"""
