"""What is known of synapse laws."""
