"""The wire: the Foxglove WebSocket protocol, access control, and the queue of each client."""
