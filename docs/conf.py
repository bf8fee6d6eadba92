"""Documentation: built with warnings as errors and without a network."""

import importlib.metadata
import sys
from pathlib import Path

sys.path.insert(
    0, str(Path(__file__).parent)
)  # `source_links`, `figures`; sphinx-gallery looks `reading_order` up by name

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
    "source_links",
    "figures",
]
exclude_patterns = [
    "_build",
    "transcript.*",
    "gallery/*.rst",
    "gallery/*.py",
    "tutorials/*.rst",
    "tutorials/*.py",
]
sphinx_gallery_conf = {
    "examples_dirs": ["tutorials", "gallery"],
    # outside the folders of the scripts, where a second build would take them for scripts too
    "gallery_dirs": ["generated/tutorials", "generated/gallery"],
    "filename_pattern": "",  # run them all
    "within_subsection_order": "conf.reading_order",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,
}
READING_ORDER = (
    # tutorials, from the paper outwards
    "two_bifurcations",
    "reading_a_bifurcation",
    "own_law",
    "own_map",
    "measured_friction",
    "from_a_record",
    "chain_of_blocks",
    "resuming_sweep",
    "lesson",
    # gallery: model, map, motion, parameters, cycles, other models, proofs
    "mechanism",
    "friction_laws",
    "event_map",
    "cobweb",
    "power",
    "basins",
    "density",
    "stick_locus",
    "phase_portraits",
    "time_series",
    "bifurcation_diagram",
    "bifurcations",
    "orbit_curve",
    "bifurcation_curve",
    "parameter_plane",
    "limit_cycles",
    "cycle_curve",
    "return_region",
    "quasistatic",
    "resonance",
    "chain_slips",
    "slip_sizes",
    "certificate",
    "proven_branches",
    "proven_basins",
)


def reading_order(name: str) -> int:
    """Sort tutorials and pictures as they are best read."""
    return READING_ORDER.index(name.removesuffix(".py"))


myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autosummary_generate = True
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
# Annotations name a class by its last part, and two observables of sweeps are named as the results
# they hold. Such a link goes to the result, which comes first.
suppress_warnings = ["ref.python"]

html_theme = "pydata_sphinx_theme"
html_title = "stickslip"
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "show_prev_next": True,
    "navigation_with_keys": False,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
