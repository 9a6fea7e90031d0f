"""Pictures: what they are for every renderer, and a renderer that needs no engine and no graphics library."""
