"""Base and effects as functions that a fit can call: what they answer to a test, and its slopes."""
