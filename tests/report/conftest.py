"""A realistic study for every test of the report, made once."""

import pytest
from synthetic_results import synthetic_pictures, synthetic_results

from fullwell.figures.results import Results
from fullwell.report.drawing.pen import Pen
from fullwell.report.html import report_html


@pytest.fixture(scope="session")
def results() -> Results:
    return synthetic_results()


@pytest.fixture(scope="session")
def page(results: Results) -> str:
    return report_html(results, synthetic_pictures())


@pytest.fixture
def words(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return every text that is written into drawings from now on: their glyphs are outlines and tell none."""
    written: list[str] = []
    write = Pen.words

    def remember(pen: Pen, text: str, *place: float, **look: object) -> None:
        written.append(text)
        write(pen, text, *place, **look)

    monkeypatch.setattr(Pen, "words", remember)
    return written
