"""Pictures of loops: original beside simulation, pulls, and how often intervals hold."""

import re

import numpy as np
from drawn import areas, lines, places_of, points

from fullwell.report.curves import Table
from fullwell.report.drawing.style import INK
from fullwell.report.loop_figures import Together
from fullwell.report.plots import color_of
from fullwell.report.plots_loop import coverage, pulls, transfer_beside

GREEN, RED = color_of("G1"), color_of("R")


def table(**columns: tuple[float | str | None, ...]) -> Table:
    return Table(columns=tuple(columns.items()))


def test_original_and_simulated_camera_share_their_axes(words: list[str]) -> None:
    whose = ("original",) * 3 + ("simulated",) * 2 + ("truth",) * 2
    channel = ("G1", "G1", "R", "G1", "R", "all", "all")
    signal = (1.0, 10.0, 100.0, 2.0, 200.0, 1.0, 300.0)
    drawn = transfer_beside(table(whose=whose, channel=channel, signal=signal, variance=signal), 100.0)
    assert points(drawn, stroke=GREEN, fill="none") == 3
    assert points(drawn, stroke=RED, fill="none") == 2
    assert len(lines(drawn, stroke="#c3cbd4")) == 2 + 1
    assert {"Original", "Simulated and measured again", "truth of the simulation"} <= set(words)
    assert "left" in drawn.caption
    ends = [word for word in words if re.fullmatch(r"[\d.]+", word)]
    assert ends[: len(ends) // 2] == ends[len(ends) // 2 :] != []


def test_pulls_have_their_histogram_and_a_line_per_quantity(words: list[str]) -> None:
    probability = tuple((np.arange(40) + 0.5) / 40.0)
    pull = tuple(np.linspace(-2.0, 2.0, 40))
    quantity = ("prnu",) * 20 + ("dsnu",) * 20
    drawn = pulls(table(quantity=quantity, probability=probability, pull=pull, of=(20.0,) * 40))
    assert len(lines(drawn, stroke="#8fa3b8")) == 2 + 1
    assert len(lines(drawn, stroke=INK, dashed=True)) == 2 + 1
    (bars,) = areas(drawn, fill="#b7c7d8")
    places = np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", bars), float)
    assert len(places) == 2 * 46
    assert places[0, 1] == places[-1, 1] == places[:, 1].max()
    assert {"All pulls", "Density", "Quantile of the normal distribution"} <= set(words)
    assert drawn.caption.startswith("40 pulls")


def together(quantity: str, covering: int) -> Together:
    numbers = dict.fromkeys(("bias", "bias_std_error", "sd", "scatter_ratio", "pull_mean", "pull_sd"), 0.0)
    return Together(
        quantity=quantity,
        method="noise-model",
        unit="1",
        snr_threshold=None,
        figures=1,
        bounds=0,
        cameras=100,
        relative=True,
        covering=covering,
        intervals=100,
        **numbers,
    )


def test_coverage_is_a_bar_per_quantity_red_where_it_is_off(words: list[str]) -> None:
    blue = color_of("B")
    assert coverage([]) is None
    drawn = coverage([together("prnu", 96), together("dsnu", 70), together("read_noise", 94)])
    assert drawn is not None
    assert points(drawn, stroke=blue, fill=blue) == 2
    assert points(drawn, stroke=RED, fill=RED) == 1
    assert [path.count("M") for path in lines(drawn, stroke=blue)] == [2]
    assert [path.count("M") for path in lines(drawn, stroke=RED)] == [1]
    assert [word for word in words if word[0].isalpha()] == ["PRNU", "DSNU", "Read noise"]
    ((_, off),) = places_of(drawn, fill=RED)
    (_, first), (_, last) = places_of(drawn, fill=blue)
    assert first < off < last
