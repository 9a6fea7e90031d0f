"""What all readers of robot and room files share."""
