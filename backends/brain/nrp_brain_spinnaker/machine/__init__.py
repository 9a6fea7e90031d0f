"""What the machine computes: all compiled code, in its arithmetic."""
