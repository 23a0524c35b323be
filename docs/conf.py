"""Sphinx's settings: ``make docs`` builds the site with warnings as errors.

The built site needs no network: the theme brings its own files, and formulas are pictures in
the page.
"""

from __future__ import annotations

import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS / "_ext"))

from example_figures import FigureScraper  # noqa: E402  found through the line above

import pitchopt  # noqa: E402

project = "pitchopt"
author = "The pitchopt authors"
project_copyright = author
version = release = pitchopt.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "generated_pages",
    "formulas",
]
exclude_patterns = ["_build", "_ext", "gallery", "**/sg_execution_times.rst"]
exclude_patterns += ["sg_execution_times.rst"]  # reads scripts from the network
exclude_patterns += ["generated/notebook-list.md"]  # included by notebooks.md
suppress_warnings = ["config.cache"]  # the scraper below is an object, which is never pickled

highlight_language = "text"  # of blocks that name none

# Markdown
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
myst_dmath_double_inline = True
myst_links_external_new_tab = False

# Docstrings: a name in single backticks is code, and a link where it is documented.
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autodoc_type_aliases = {name: name for name in ("ArrayLike", "BoolArray", "FloatArray", "IntArray")}
autosummary_generate = False
maximum_signature_line_length = 88
add_module_names = False
python_use_unqualified_type_names = True
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
numpydoc_xref_param_type = False

html_theme = "furo"
html_title = f"pitchopt {release}"
html_math_renderer = "svg"
html_static_path = ["_static"]
html_css_files = ["pitchopt.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
    "filename_pattern": r"plot_",
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": (FigureScraper(),),
    "reset_modules": ("matplotlib",),
    "abort_on_example_error": True,
    "only_warn_on_example_error": False,
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "remove_config_comments": True,
    "plot_gallery": "True",
    "min_reported_time": 1,
}
