"""How Sphinx builds the pages: `make docs`."""

import sys
from pathlib import Path

import sherd

sys.path.insert(0, str(Path(__file__).parent))  # for mathml.py

project = "sherd"
author = "The sherd authors"
project_copyright = "the sherd authors, MIT license"
version = release = sherd.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "mathml"]
html_math_renderer = "mathml"
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
# ```math and $...$ are what GitHub, GitLab and Forgejo typeset, too
myst_fence_as_directive = ["math"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "tables"]

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_class_signature = "separated"
napoleon_google_docstring = False
napoleon_use_rtype = False

# n' is a prime, not the end of a quotation
smartquotes = False

html_theme = "furo"
html_title = "sherd"
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["pages.css"]
