"""The report."""

from fullwell.figures.results import Results
from fullwell.report.pictures import Pictures


def report_html(results: Results, pictures: Pictures | None) -> str:
    """Return the report as one self-contained page."""
    return f"<!doctype html><title>Fullwell</title><p>{len(results.rows)} {pictures is None}"
