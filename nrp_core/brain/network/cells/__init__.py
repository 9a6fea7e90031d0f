"""What is known of cell types."""
