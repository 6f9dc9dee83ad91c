"""Where a model misses the data, and the verdict as its file says it."""
