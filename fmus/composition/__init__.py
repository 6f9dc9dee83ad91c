"""Composition: systems of components, imposed motion, added force, components by folder and by value file."""
