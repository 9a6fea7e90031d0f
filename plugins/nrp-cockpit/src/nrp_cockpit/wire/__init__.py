"""The wire: the Foxglove WebSocket protocol, who may use it, and what waits for each client."""
