"""Formulas as MathML, which browsers show by themselves: the site needs no network."""

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert

NAME = r"<m[io]>(?:sin|cos|exp|log|max|det)</m[io]>"
THIN = '<mspace width="0.17em"/>'
BETWEEN = (
    re.compile(f"(</m(?:i|n|sub|sup|row|frac|over|sqrt)>)({NAME})"),  # A sin
    re.compile(f"({NAME})(<m(?:i|n|sub|sup|row|frac|over|sqrt)>)"),  # sin x, but sin(x)
)


def setup_mathml(app: Any) -> None:
    """Register the renderer `mathml`."""
    app.add_html_math_renderer("mathml", (_visit_inline, None), (_visit_block, None))


def mathml(latex: str, **how: str) -> str:
    """A formula of LaTeX; names of functions stand apart from what they are not bracketed with."""
    text = convert(latex, **how)
    for pattern in BETWEEN:
        text = pattern.sub(rf"\1{THIN}\2", text)
    return text


def _visit_inline(self: Any, node: Any) -> None:
    self.body.append(mathml(node.astext()))
    raise nodes.SkipNode


def _visit_block(self: Any, node: Any) -> None:
    self.body.append(self.starttag(node, "div", CLASS="math", style="overflow-x: auto"))
    self.body.append(mathml(node.astext(), display="block"))
    self.body.append("</div>")
    raise nodes.SkipNode
