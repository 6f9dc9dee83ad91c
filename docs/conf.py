"""The site: `pip install '.[docs]' && sphinx-build -nW docs site`. Pages are executed by the build; tables come
from the code."""

import sys
from pathlib import Path

import motofmi

sys.path.insert(0, str(Path(__file__).parent))  # the extension beside this file
sys.path.append(str(Path(__file__).parents[1]))  # the benchmarks, whose results pages show

project = "motofmi"
author = "motofmi developers"
release = motofmi.__version__
extensions = [
    "myst_nb",
    "sphinx_gallery.gen_gallery",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx-mathjax-offline",
    "sphinx_copybutton",
    "extension",
]
exclude_patterns = [
    "components/README.md",
    "examples/*",
    "how_to/gallery/*.ipynb",
    "how_to/gallery/*.py",
    "**/.ipynb_checkpoints",
]
html_theme = "furo"
html_title = f"motofmi {release}"
html_show_sphinx = False
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["site.css"]

# Pages that are executed fail the build where they fail.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 240
nb_execution_in_temp = True
nb_merge_streams = True
nb_output_stderr = "remove"  # progress

# Scripts with pictures, executed as well.
sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "how_to/gallery",
    "abort_on_example_error": True,
    "show_memory": False,
    "download_all_examples": False,
    "show_signature": False,
    "capture_repr": (),
    "min_reported_time": 1e9,
    "write_computation_times": False,
}

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 4
myst_fence_as_directive = ["math"]  # as the forges write equations
autodoc_typehints = "none"
autodoc_member_order = "bysource"
# Docstrings are plain text with indented examples, not reStructuredText references.
nitpick_ignore_regex = [("py:.*", ".*")]
suppress_warnings = ["myst.header"]
