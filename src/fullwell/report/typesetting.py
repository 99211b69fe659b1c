"""Typst's only door: a template with its data becomes a PDF, a drawing becomes pixels, without a network.

The same bytes come out for the same data.
"""

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Final, Literal

import typst

from fullwell.report.drawing.text import FONTS

_SHEET: Final = '#set page(width: auto, height: auto, margin: 0pt)\n#image("drawing.svg")'


def pdf_of(template: str, *, data: object, drawings: Mapping[str, bytes]) -> bytes:
    """Return the PDF of a document.

    Parameters
    ----------
    template
        Typst source; it reads ``data.json`` and the drawings, and nothing else. What the data hold is text to it,
        never markup.
    data
        JSON-ready.
    drawings
        SVG by file name.

    """
    files = {"data.json": json.dumps(data, ensure_ascii=False).encode()}
    return _compiled(template, files | dict(drawings), form="pdf")


def png_of(drawing: bytes, *, per_inch: float) -> bytes:
    """Return an SVG as a PNG.

    Parameters
    ----------
    drawing
        The SVG.
    per_inch
        Pixels of an inch.

    """
    return _compiled(_SHEET, {"drawing.svg": drawing}, form="png", per_inch=per_inch)


def _compiled(
    template: str, files: Mapping[str, bytes], *, form: Literal["pdf", "png"], per_inch: float | None = None
) -> bytes:
    with tempfile.TemporaryDirectory(prefix="fullwell-") as name:
        folder = Path(name)
        for file, content in files.items():
            (folder / file).write_bytes(content)
        (folder / "main.typ").write_text(template, encoding="utf-8")
        fonts = typst.Fonts(include_system_fonts=False, font_paths=[FONTS])
        compiler = typst.Compiler(
            folder / "main.typ", root=folder, font_paths=fonts, package_path=folder, package_cache_path=folder
        )
        made = compiler.compile(format=form, ppi=per_inch, timestamp=0)
    if not isinstance(made, bytes):
        raise TypeError("a document of one page is one piece")
    return made
