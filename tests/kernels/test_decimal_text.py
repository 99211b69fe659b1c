"""Numbers as text are what Python's own formatting says."""

import math
from decimal import Decimal

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from fullwell.kernels.decimal_text import DIGITS, LONGEST, put_lines


def text_of(*rows: list[float]) -> str:
    values = np.array(rows)
    out = np.empty(LONGEST * values.size, np.uint8)
    return out[: put_lines(values, out)].tobytes().decode()


@given(st.floats())
@example(1.7976931348623157e308)
@example(-5e-324)
@example(999999999999.5)
@example(9.9999999999995e-5)
@example(-123456789012e-15)
@example(-0.000123456789012)
def test_a_number_is_written_as_python_does(value: float) -> None:
    text, expected = text_of([value]).removesuffix("\n"), format(value, f".{DIGITS}g")
    if text != expected and value != 0.0:  # on the verge of two, either will do
        assert math.isfinite(value)
        unit = Decimal(10) ** (Decimal(value).adjusted() - DIGITS + 1)
        assert abs(Decimal(text) - Decimal(value)) <= Decimal("0.5005") * unit
        assert text == format(float(text), f".{DIGITS}g")


def test_rows_become_lines() -> None:
    assert text_of([1.0, -2.5, 0.0], [-0.0, 1e300, np.nan]) == "1,-2.5,0\n0,1e+300,nan\n"
