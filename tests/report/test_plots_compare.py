"""Pictures of comparisons: each difference in standard errors, all photon transfer curves in one panel."""

import re

import pytest
from drawn import areas, places_of, points

from fullwell.figures.results import Column, Curve, Results, Row
from fullwell.figures.side_by_side import Side, compare
from fullwell.report.plots import color_of
from fullwell.report.plots_compare import comparison_pictures
from fullwell.units import DN, DN2, ELECTRON, PERCENT, Measured

GREEN = color_of("G1")
STEPS = 4.0
"""Standard errors that the one figure of `sides` which differs is off."""


def recommended(quantity: str, value: float, unit: str, *, error: float = 0.1) -> Row:
    measured = Measured.normal(value, error, unit)
    return Row(
        quantity=quantity, channel="G1", method="noise-model", measured=measured, flags=("recommended",), iso=1e2
    )


def transfer(signal: tuple[float, ...]) -> Curve:
    columns = {"iso": ("", (100.0,) * len(signal)), "channel": ("", ("G1",) * len(signal))}
    columns |= {"kind": ("", ("flat",) * len(signal)), "signal": (DN, signal), "variance": (DN2, signal)}
    made = (Column(name=name, unit=unit, values=values) for name, (unit, values) in columns.items())
    return Curve(name="photon_transfer", columns=tuple(made))


def sides(count: int, *, off: float) -> list[Side]:
    """Return sides of which every other than A has a read noise that is ``off`` standard errors from A's."""
    made: list[Side] = []
    for at in range(count):
        away = 0.0 if at == 0 else off * 2.0**0.5 * 0.1
        rows = (recommended("read_noise", 5.0 + away, ELECTRON), recommended("prnu", 0.5, PERCENT))
        results = Results(study={}, rows=rows, findings=(), curves=(transfer((10.0, 100.0, 1000.0)),))
        made.append(Side(label="ABC"[at], name="abc"[at], results=results))
    return made


def test_differences_stand_in_standard_errors_one_marker_each(words: list[str]) -> None:
    first, _ = comparison_pictures(compare(sides(3, off=STEPS)))
    assert points(first, stroke=GREEN, fill=GREEN) == 2  # B is filled; one channel needs no legend
    assert points(first, stroke=GREEN, fill="none") == 2  # C is open
    assert {"Read noise", "PRNU", "Difference from A [standard errors]"} <= set(words)


@pytest.mark.parametrize(("off", "shown"), [(STEPS, STEPS), (50.0, 8.0), (-50.0, -8.0)])
def test_what_differs_too_much_stands_at_the_edge(off: float, shown: float) -> None:
    first, _ = comparison_pictures(compare(sides(2, off=off)))
    left, _, right = (float(one) for one in re.findall(r"-?[\d.]+", areas(first, fill="#eef2f5")[0])[:3])
    middle, error = (left + right) / 2.0, (right - left) / 4.0
    found = sorted(x for x, _ in places_of(first, fill=GREEN))
    assert found == pytest.approx(sorted([middle, middle + error * shown]), abs=0.02)


def test_photon_transfer_of_all_sides_is_in_one_panel(words: list[str]) -> None:
    _, second = comparison_pictures(compare(sides(2, off=STEPS)))
    assert points(second, stroke=GREEN, fill=GREEN) == 3
    assert points(second, stroke=GREEN, fill="none") == 3
    assert {"ISO 100", "Signal above black [DN]", "Variance [DN²]"} <= set(words)
