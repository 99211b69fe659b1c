"""A datasheet is the same whoever makes it, and is made here where the other process fails."""

import subprocess
import sys

import pytest
from synthetic_emva import synthetic_campaign

from fullwell.report.datasheet import making
from fullwell.report.datasheet.build import build_datasheet
from fullwell.report.datasheet.making import datasheet_maker
from fullwell.report.datasheet.pdf import datasheet_pdf


@pytest.fixture(scope="module")
def campaign():
    return synthetic_campaign(isos=(100.0,))


@pytest.fixture(scope="module")
def expected(campaign):
    sheet = build_datasheet(campaign)
    return sheet, datasheet_pdf(sheet)


def made(campaign, *, apart):
    with datasheet_maker(apart=apart) as maker:
        maker.begin(campaign)
        return maker.datasheet(), maker.pdf()


@pytest.mark.parametrize("apart", [False, True])
def test_a_datasheet_is_the_same_whoever_makes_it(campaign, expected, monkeypatch, apart):
    monkeypatch.setattr(making.os, "cpu_count", lambda: 2)
    assert made(campaign, apart=apart) == expected


@pytest.mark.parametrize("program", ["fullwell.no_such_module", "this"])
def test_a_process_that_fails_is_replaced(campaign, expected, monkeypatch, program):
    monkeypatch.setattr(making.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(making, "_PROGRAM", program)  # one ends at once, the other prints what is no answer
    assert made(campaign, apart=True) == expected


def test_the_other_process_has_nothing_to_print_where_there_is_no_datasheet(results, monkeypatch):
    monkeypatch.setattr(making.os, "cpu_count", lambda: 2)
    with datasheet_maker(apart=True) as maker:
        maker.begin(results)
        assert maker.datasheet() is None


def test_nothing_that_draws_loads_with_the_measurement():
    heavy = ("matplotlib", "pydantic", "jinja2", "pyarrow", "scipy.optimize", "scipy.ndimage")
    code = f"import sys, fullwell.workflow.characterize; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
