import warnings

import pytest
from matplotlib.figure import Figure

from fullwell.report.plots import log_axis


@pytest.mark.parametrize("which", ["x", "y"])
def test_nothing_above_zero_draws_an_empty_axis_without_a_warning(which: str) -> None:
    axes = Figure().subplots()
    axes.plot(*(([0.0, 0.0], [1.0, 2.0]) if which == "x" else ([1.0, 2.0], [0.0, 0.0])))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        log_axis(axes, which)
    low, high = axes.get_xlim() if which == "x" else axes.get_ylim()
    assert 0.0 < low < high


@pytest.mark.parametrize("which", ["x", "y"])
def test_limits_that_were_set_stay_though_nothing_is_drawn_yet(which: str) -> None:
    axes = Figure().subplots()
    (axes.set_xlim if which == "x" else axes.set_ylim)(1e-5, 2.0)
    log_axis(axes, which)
    assert (axes.get_xlim() if which == "x" else axes.get_ylim()) == (1e-5, 2.0)
