"""Settings of Sphinx; `python -m docs.build` calls it."""

from __future__ import annotations

import bsm_mesh

project = "bsm-mesh"
author = copyright = "the bsm-mesh developers"
release = bsm_mesh.__version__
root_doc = "index"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_design"]
exclude_patterns = ["bsm_mesh", "tests/**/*.rst"]
html_theme = "pydata_sphinx_theme"
html_theme_options = {
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "header_links_before_dropdown": 6,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": ["theme-version"],
}
html_title = f"bsm-mesh {release}"
html_show_sourcelink = False
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["narrow.css"]

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
suppress_warnings = ["myst.header"]  # pages of the repository may begin as they like

napoleon_google_docstring = False
napoleon_use_ivar = True  # a list of attributes, not a heading for each
napoleon_use_rtype = False
autodoc_typehints = "none"  # docstrings say shape and unit, which types do not
autodoc_member_order = "bysource"
autodoc_class_signature = "mixed"
add_module_names = False
python_maximum_signature_line_length = 88
default_role = "code"  # `name` in a docstring
highlight_language = "text"
