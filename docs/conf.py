"""How Sphinx builds the pages: `make docs`."""

import sherd

project = "sherd"
author = "The sherd authors"
project_copyright = "the sherd authors, MIT license"
version = release = sherd.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["colon_fence", "deflist"]
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
