"""A network on a real machine: placement, cost and losses."""
