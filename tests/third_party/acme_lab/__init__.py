"""What a laboratory adds to nrp-core from outside: one part for each door."""
