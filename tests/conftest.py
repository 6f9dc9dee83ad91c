"""Property tests draw the same examples in every run, on every machine, however slow."""

from hypothesis import settings

settings.register_profile("reproducible", derandomize=True, deadline=None)
settings.load_profile("reproducible")
