"""The readers of recordings, one file per format: each declares its suffixes in FORMAT, and is found by
being in this folder."""
