"""A cart that its neurons push through a plume."""
