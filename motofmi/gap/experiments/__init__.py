"""Experiments: the component under test, its free parameters, and how effects are added to it."""
