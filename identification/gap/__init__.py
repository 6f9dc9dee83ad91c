"""The gap workflow: where a model misses measured data, which physical effect is missing, and what it changes."""
