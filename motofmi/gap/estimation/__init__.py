"""Parameter estimation: the base and effects fitted to runs."""
