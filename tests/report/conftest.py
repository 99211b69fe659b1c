"""A realistic study for every test of the report, made once."""

import pytest
from synthetic_results import synthetic_pictures, synthetic_results

from fullwell.figures.results import Results
from fullwell.report.html import report_html


@pytest.fixture(scope="session")
def results() -> Results:
    return synthetic_results()


@pytest.fixture(scope="session")
def page(results: Results) -> str:
    return report_html(results, synthetic_pictures())
