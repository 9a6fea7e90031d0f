"""What engines with joints share: bodies, servos, drives, options."""
