"""Figures, tables and HTML pages from results."""
