"""The shared part of all readers of robot and room files."""
