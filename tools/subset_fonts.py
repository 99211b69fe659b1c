"""Cut the fonts of the pictures and the datasheet out of the full DejaVu fonts.

``python tools/subset_fonts.py FOLDER`` reads DejaVuSans.ttf, -Bold and -Oblique from FOLDER (DejaVu 2.37) and writes
what `fullwell.report.fonts` ships: Latin, Greek, Cyrillic, punctuation, super- and subscripts, currencies, arrows,
mathematical operators, without hints.
"""

import sys
from pathlib import Path
from typing import Final

from fontTools.subset import main as subset

FACES: Final = ("DejaVuSans", "DejaVuSans-Bold", "DejaVuSans-Oblique")
KEPT: Final = (
    "U+0020-007E",
    "U+00A0-024F",
    "U+02B0-02DD",
    "U+0370-03FF",
    "U+0400-045F",
    "U+1E00-1EFF",
    "U+2000-206F",
    "U+2070-209F",
    "U+20A0-20BF",
    "U+2100-214F",
    "U+2150-218B",
    "U+2190-21FF",
    "U+2200-22FF",
    "U+2300-2311",
    "U+25A0-25FF",
    "U+FFFD",
)
TARGET: Final = Path(__file__).parents[1] / "src" / "fullwell" / "report" / "fonts"


def main(source: Path) -> None:
    """Write the fonts."""
    for face in FACES:
        subset(
            [
                str(source / f"{face}.ttf"),
                f"--unicodes={','.join(KEPT)}",
                f"--output-file={TARGET / face}.ttf",
                "--layout-features=kern,mark,mkmk,ccmp",
                "--legacy-kern",
                "--no-hinting",
                "--notdef-outline",
                "--name-IDs=*",
            ]
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
