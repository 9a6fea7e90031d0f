"""The computations of the machine: all compiled code, in its arithmetic."""
