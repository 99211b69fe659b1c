"""Typst's only door: a template with its data becomes a PDF, the same bytes for the same data, without a network."""

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path

import typst

from fullwell.report.plots import font_folder


def compiled(template: str, *, data: object, drawings: Mapping[str, bytes]) -> bytes:
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
    with tempfile.TemporaryDirectory(prefix="datasheet-") as name:
        folder = Path(name)
        (folder / "data.json").write_text(json.dumps(data, ensure_ascii=False), encoding="utf-8")
        for drawing, content in drawings.items():
            (folder / drawing).write_bytes(content)
        (folder / "main.typ").write_text(template, encoding="utf-8")
        fonts = typst.Fonts(include_system_fonts=False, font_paths=[font_folder()])
        compiler = typst.Compiler(
            folder / "main.typ", root=folder, font_paths=fonts, package_path=folder, package_cache_path=folder
        )
        made = compiler.compile(format="pdf", timestamp=0)
    if not isinstance(made, bytes):
        raise TypeError("a PDF is one piece")
    return made
