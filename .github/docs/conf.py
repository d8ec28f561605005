"""Configuration of Sphinx for `make docs`.

The pages are those of the guide, and those that `pages.py` writes. They need no network: formulas
are MathML, the search runs in the browser, and fonts are those of the reader's system.
"""

import re

from docutils.nodes import SkipNode
from latex2mathml.converter import convert
from pygments.lexers.special import TextLexer
from sphinx.highlighting import lexers

import shockpc

project = "shockpc"
author = "The shockpc developers"
release = version = shockpc.__version__
copyright = "the shockpc developers, BSD 2-Clause"

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb"}
root_doc = "index"
html_theme = "furo"
html_title = f"shockpc {version}"
html_copy_source = False
# A table of a log is text.
lexers["csv"] = TextLexer()
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["pages.css"]
default_role = "literal"

myst_heading_anchors = 4
myst_links_external_new_tab = False
myst_url_schemes = ("http", "https", "mailto")
# Names of attributes in a docstring are no references, so that equal ones are not ambiguous.
suppress_warnings = ["ref.python"]
# A notebook is executed while the site is built: its assertions hold, or there is no site.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_format = "short"
autodoc_typehints_description_target = "documented"
autodoc_class_signature = "separated"
autodoc_default_options = {"members": True, "exclude-members": "__new__, __init__"}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

LITERAL = re.compile(r"(\.\. math::\n(?:\n|[ ]+.*\n?)+|:math:`[^`]+`|``[^`]+``|`[^`]+`)")
"""Parts of a docstring in which reStructuredText marks nothing up."""
MARKS = re.compile(r"([\\*|]|(?<=\w)_(?=\W|$))")
"""Signs that docstrings use as they are, as in |v| and `*_KFE`, and reStructuredText as markup."""


def as_text(app, what, name, obj, options, lines):
    """Make the words of a docstring words of reStructuredText, and code of what is in backticks."""
    parts = LITERAL.split("\n".join(lines))
    parts[::2] = [MARKS.sub(r"\\\1", part) for part in parts[::2]]
    code = re.compile(r"`([^`]+)`")
    parts[1::2] = [
        code.sub(r"``\1``", part) if code.fullmatch(part) else part for part in parts[1::2]
    ]
    lines[:] = "".join(parts).split("\n")


def skip_field(app, what, name, obj, skip, options):
    """Skip the fields of a named tuple, which its docstring lists."""
    return True if str(obj.__doc__).startswith("Alias for field number") else skip


def write_inline(self, node):
    """Write a formula in a line of text."""
    self.body.append(convert(node.astext()))
    raise SkipNode


def write_block(self, node):
    """Write a formula on a line of its own."""
    self.body.append(convert(node.astext(), display="block"))
    raise SkipNode


def setup(app):
    """Register what this file defines."""
    # Before napoleon, which writes marks of its own, at 500.
    app.connect("autodoc-process-docstring", as_text, priority=400)
    app.connect("autodoc-skip-member", skip_field)
    app.add_html_math_renderer("mathml", (write_inline, None), (write_block, None))
    return {"parallel_read_safe": True}
