"""The cache of archives, of compiled files and of libraries: its folder, and keys of contents.

The folder is the user's cache folder of the platform, or that in the environment variable MOTOFMI_CACHE.
"""

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path

import platformdirs

from fmus.support.files import writable_folder


def cache_folder() -> Path:
    """The folder of the cache. Raises InputError when it cannot be written."""
    return writable_folder(os.environ.get("MOTOFMI_CACHE") or platformdirs.user_cache_dir("motofmi"))


def content_key(contents: Mapping[str, bytes], *more: str) -> str:
    """SHA-256 over names and bytes."""
    digest = hashlib.sha256()
    for item in (*more, *(part for pair in sorted(contents.items()) for part in pair)):
        data = item if isinstance(item, bytes) else item.encode()
        digest.update(len(data).to_bytes(8, "big") + data)
    return digest.hexdigest()
