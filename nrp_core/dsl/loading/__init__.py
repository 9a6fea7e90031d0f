"""Files of transfer functions: imports, listing, execution."""
