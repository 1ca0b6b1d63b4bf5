"""Equations of the pages as MathML, written while they are built.

Every browser since 2023 draws MathML by itself, so the built pages need neither a network nor a
script, unlike MathJax. An equation that cannot be converted fails the build.
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError


def mathml(equation: str, display: str) -> str:
    """LaTeX as a MathML element.

    What the converter does not know it passes on as letters: a command with its backslash, and the
    column marks of an environment. Readers should not be the first to notice.
    """
    converted = convert(equation, display=display)
    if "<mi>&</mi>" in converted or "<mi>\\" in converted:
        raise ExtensionError(f"a command or environment without MathML in: {equation}")
    return converted


def inline_equation(writer: Any, node: nodes.math) -> None:
    """An equation within a line."""
    writer.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def displayed_equation(writer: Any, node: nodes.math_block) -> None:
    """An equation on lines of its own."""
    writer.body.append(f'<div class="math">{mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this for each extension."""
    app.add_html_math_renderer("mathml", (inline_equation, None), (displayed_equation, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
