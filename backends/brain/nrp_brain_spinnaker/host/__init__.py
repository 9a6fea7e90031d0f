"""What the host computes before a run: numbers and tables as they are loaded onto the machine."""
