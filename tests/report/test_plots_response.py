"""Pictures of exposure series: a point for every exposure, a line of steps for every histogram."""

from drawn import lines, points

from fullwell.report.curves import Table
from fullwell.report.plots import color_of
from fullwell.report.plots_response import exposure_series

GREEN, RED = color_of("G1"), color_of("R")


def table(**columns: tuple[float | str | None, ...]) -> Table:
    return Table(columns=tuple(columns.items()))


def test_response_is_a_point_per_exposure_and_a_line_per_channel(words: list[str]) -> None:
    response = table(
        channel=("G1",) * 3 + ("R",) * 3,
        exposure_s=(0.01, 0.02, 0.04) * 2,
        signal=(100.0, 200.0, 400.0, 50.0, 100.0, 200.0),
        fitted=(100.0, 200.0, 400.0, 50.0, 100.0, 200.0),
        deviation=(0.0, 0.01, -0.01) * 2,
    )
    drawn = exposure_series(response, None, 100.0)
    in_legend = 1
    assert points(drawn, stroke=GREEN, fill=GREEN) == 6 + in_legend
    assert len(lines(drawn, stroke=RED, dashed=False)) == 1
    assert len(lines(drawn, stroke=RED, dashed=True)) == 1
    assert {"Response", "Deviation from proportionality", "0.20", "proportional"} <= set(words)
    assert "Histograms, every exposure" not in words


def test_histograms_are_steps_with_gaps_where_a_code_is_missing(words: list[str]) -> None:
    histograms = table(
        channel=("G1",) * 6,
        exposure_s=(0.01,) * 3 + (0.02,) * 3,
        code=(10.0, 11.0, 12.0, 20.0, 21.0, 23.0),
        count=(1.0, 5.0, 1.0, 2.0, 9.0, 3.0),
    )
    drawn = exposure_series(None, histograms, 100.0)
    paths = lines(drawn, stroke=GREEN)
    assert [path.count("M") for path in paths] == [1, 2]
    assert {"Histograms, every exposure", "Raw value [DN]"} <= set(words)
