"""The transfer function framework under the name that its paper prints."""
