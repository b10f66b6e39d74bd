"""Formulas as MathML, which browsers show by themselves: the site needs no network."""

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.transforms import SphinxTransform

NAME = r"<m[io]>(?:sin|cos|exp|log|max|det)</m[io]>"
POWER = re.compile(r"(?<=[\w)])\^(-?\d+(?:\.\d+)?|[a-z]\b|\([^()]{1,9}\))")
AS_IT_STANDS = (nodes.literal, nodes.literal_block, nodes.math, nodes.math_block, nodes.raw, nodes.title)
THIN = '<mspace width="0.17em"/>'
SIGN = re.compile(
    r"(<m[io]>(?:&#x000(?:28|3C|3D|3E);|&#x0226[45];|[=(,;])</m[io]>)<mo>(?=&#x0(?:2212|002B);)"
)
DOT = re.compile(r"<mover>((?:(?!<mover>).)*?<mo>&#x00(?:0A8|2D9);</mo></mover>)")
BETWEEN = (
    re.compile(f"(</m(?:i|n|sub|sup|row|frac|over|sqrt)>)({NAME})"),  # A sin
    re.compile(f"({NAME})(<m(?:i|n|sub|sup|row|frac|over|sqrt)>)"),  # sin x, but sin(x)
)


def setup_mathml(app: Any) -> None:
    """Register the renderer `mathml`."""
    app.add_transform(Superscripts)
    app.add_html_math_renderer("mathml", (_visit_inline, None), (_visit_block, None))


class Superscripts(SphinxTransform):
    """Powers in running text, such as u^2 or x^(1/2), as superscripts; code and formulas stay as they are."""

    default_priority = 900

    def apply(self, **_: Any) -> None:
        for text in list(self.document.findall(nodes.Text)):
            if POWER.search(text) and not any(isinstance(text.parent, each) for each in AS_IT_STANDS):
                text.parent.replace(text, with_powers(str(text)))


def with_powers(text: str) -> list[nodes.Node]:
    """A text as nodes, its powers as superscripts."""
    pieces = POWER.split(text)
    return [
        nodes.superscript(piece, piece.strip("()")) if i % 2 else nodes.Text(piece)
        for i, piece in enumerate(pieces)
        if piece
    ]


def mathml(latex: str, **how: str) -> str:
    """A formula of LaTeX; names of functions stand apart from what they are not bracketed with.

    Dots over letters are as large as letters, and a sign behind a relation stands at its number.
    """
    text = DOT.sub(r'<mover accent="true">\1', convert(latex, **how))
    text = SIGN.sub(r'\1<mo form="prefix">', text)
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
