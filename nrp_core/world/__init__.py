"""The world side: scenes, messages, topics, and the interface of a physics engine."""
