"""Documentation: built with warnings as errors and without a network."""

import importlib.metadata
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # sphinx-gallery looks `reading_order` up by name

project = "stickslip"
author = "stickslip developers"
copyright = "stickslip developers"
release = version = importlib.metadata.version("stickslip")

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "transcript.*", "tutorials/*.rst", "tutorials/*.py"]
sphinx_gallery_conf = {
    "examples_dirs": ["tutorials"],
    "gallery_dirs": ["tutorials/generated"],
    "filename_pattern": "",  # run them all
    "within_subsection_order": "conf.reading_order",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 1e9,
}
TUTORIALS = (
    "two_bifurcations",
    "reading_a_bifurcation",
    "own_law",
    "own_map",
    "measured_friction",
    "chain_of_blocks",
    "resuming_sweep",
    "lesson",
)


def reading_order(name: str) -> int:
    """Sort the tutorials from the paper outwards."""
    return TUTORIALS.index(name.removesuffix(".py"))


myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autosummary_generate = True
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

html_theme = "pydata_sphinx_theme"
html_title = "stickslip"
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "show_prev_next": False,
    "navigation_with_keys": False,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
