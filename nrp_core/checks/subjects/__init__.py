"""The checks, one module for each subject; importing ``experiments`` or ``functions`` registers them."""
