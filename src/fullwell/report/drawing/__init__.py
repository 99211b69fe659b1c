"""The drawing room: figures as SVG, laid out by measured text, drawn in some milliseconds.

`Figure` is a sheet, `Axes` a panel on it, `key` an entry of a legend.
"""

from fullwell.report.drawing.axes import Axes
from fullwell.report.drawing.colors import DIVERGING, GRAYS, VIRIDIS, Colors, rgb, shades
from fullwell.report.drawing.figure import Figure
from fullwell.report.drawing.images import Shown
from fullwell.report.drawing.legend import Key, key

__all__ = ["DIVERGING", "GRAYS", "VIRIDIS", "Axes", "Colors", "Figure", "Key", "Shown", "key", "rgb", "shades"]
