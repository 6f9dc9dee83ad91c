"""Batches of recordings: the same workflow on every test of a folder or of a manifest, one table of the results."""
