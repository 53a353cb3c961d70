"""Settings of the documentation site: `python -m sphinx -W docs docs/_build`.

Everything that the pages load lies in the build folder: they can be read without a network.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from docutils import nodes
from latex2mathml.converter import convert

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS / "scripts"))

from reference_pages import write_pages  # noqa: E402  in that folder

if TYPE_CHECKING:
    from docutils.nodes import math, math_block
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

project = "tauten"
author = "The tauten developers"
project_copyright = "The tauten developers"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
]
templates_path = ["_templates"]
exclude_patterns = ["_build", "_templates", "scripts", "results", "figures"]
html_theme = "furo"
html_title = "tauten"
html_show_sphinx = False

default_role = "py:obj"
autosummary_ignore_module_all = False
autosummary_imported_members = True
myst_heading_anchors = 3
myst_enable_extensions = ["dollarmath", "amsmath"]
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_class_signature = "separated"
autodoc_member_order = "bysource"
napoleon_use_ivar = True
napoleon_google_docstring = True
python_use_unqualified_type_names = True

# Pictures that are not drawn on white, or have a version for the dark.
PHOTOGRAPHS = ("viewer-", "film-", "five-minutes", "own-robot")
SECTION = re.compile(r"(Args|Attributes|Returns|Raises|Yields|Note):")
OUTSIDE = re.compile(r"\[([^\]]+)\]\((\.\./[^)#]+)(?:#[^)]*)?\)")


def offline_links(app: Sphinx, page: str, source: list[str]) -> None:
    """Turn links to files of the repository into downloads, and to its folders into their names.

    Args:
        app: not used.
        page: name of the page.
        source: its text, replaced in place.
    """

    def link(match: re.Match[str]) -> str:
        text, target = match.groups()
        path = (DOCS / page).parent / target
        within = path.resolve().is_relative_to(DOCS)
        if within or not path.is_file():
            return match.group(0) if within else f"{text.strip('`')} (`{target.lstrip('./')}`)"
        return f"{{download}}`{text.strip('`')} <{target}>`"

    source[0] = OUTSIDE.sub(link, source[0])


def literal_equations(
    app: Sphinx, what: str, name: str, item: object, options: object, lines: list[str]
) -> None:
    """Mark indented equations of a docstring as literal text, before napoleon reads its sections.

    Args:
        app: not used.
        what: kind of the item, not used.
        name: of the item, not used.
        item: not used.
        options: not used.
        lines: of the docstring, replaced in place.
    """
    result: list[str] = []
    in_section = in_block = False
    for index, line in enumerate(lines):
        in_section = in_section or bool(SECTION.match(line))
        starts = line.startswith("    ") and index > 0 and not lines[index - 1].strip()
        if not in_section and not in_block and starts:
            result += ["::", ""]
            in_block = True
        elif line.strip() and not line.startswith("    "):
            in_block = False
        result.append(line if in_block else line.replace("|", r"\|").replace("*", r"\*"))
    lines[:] = result


def mathml(writer: HTML5Translator, node: math) -> None:
    """Write an equation within a line as MathML, which browsers draw themselves."""
    writer.body.append(convert(node.astext()))
    raise nodes.SkipNode


def mathml_block(writer: HTML5Translator, node: math_block) -> None:
    """Write a displayed equation as MathML."""
    equation = convert(node.astext(), display="block")
    writer.body.append(f'<div class="equation">{equation}</div>')
    raise nodes.SkipNode


def mark_plots(app: Sphinx, tree: nodes.document) -> None:
    """Mark plots, whose lightness is inverted in the dark (`_static/site.css`).

    Args:
        app: not used.
        tree: of a page, whose images get a class.
    """
    for image in tree.findall(nodes.image):
        if not Path(image["uri"]).name.startswith(PHOTOGRAPHS):
            image["classes"].append("plot")


def setup(app: Sphinx) -> None:
    """Write equations as MathML, and the generated pages before the others are read."""
    app.add_html_math_renderer("mathml", (mathml, None), (mathml_block, None))
    app.connect("config-inited", lambda app, config: write_pages(DOCS / "reference"))
    app.connect("doctree-read", mark_plots)
    app.connect("source-read", offline_links)
    app.connect("autodoc-process-docstring", literal_equations, priority=100)
