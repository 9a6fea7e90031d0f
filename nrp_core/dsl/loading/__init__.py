"""Files of transfer functions: their imports, their listing, their execution."""
