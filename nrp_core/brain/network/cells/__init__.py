"""Cell types, one module a family; :mod:`nrp_core.brain.network.cells.types` lists them."""
