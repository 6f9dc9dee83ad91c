"""Model selection: candidate search over the library, pairs, ties, and the verdict."""
