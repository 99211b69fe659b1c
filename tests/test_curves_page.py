"""docs/results.md names every curve that results.json may hold."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NAMED = re.compile(r'(?:Curve\(\s*name=|_curve\(\s*)"(\w+)"')


def test_every_curve_is_described() -> None:
    rooms = [ROOT / "src/fullwell/workflow" / room for room in ("measure", "published")]
    sources = [path.read_text(encoding="utf-8") for room in rooms for path in room.rglob("*.py")]
    names = {name for source in sources for name in NAMED.findall(source)}
    assert {"photon_transfer", "chart_points", "dark_histogram", "prnu_tiles_legacy"} <= names
    page = (ROOT / "docs/results.md").read_text(encoding="utf-8").partition("## Curves")[2].partition("\n## ")[0]
    assert {name for name in names if f"`{name}`" not in page} == set()
