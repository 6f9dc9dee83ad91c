"""Experiment design: which effects a planned experiment could name, and which further runs would resolve a verdict."""
