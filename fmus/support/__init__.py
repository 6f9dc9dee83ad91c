"""Shared support: errors, files, modules, JSON, progress bars, processes, printed tables."""
