"""What is to be seen in a picture: points and lines by colour, and the photographs in it."""

import base64
import io
import xml.etree.ElementTree as ET

import numpy as np
from PIL import Image

from fullwell.report.plots import Picture, drawing_of

SVG = "{http://www.w3.org/2000/svg}"


def parsed(picture: Picture) -> ET.Element:
    return ET.fromstring(drawing_of(picture))  # noqa: S314 - a drawing of our own


def points(picture: Picture, *, stroke: str, fill: str) -> int:
    """Return how many markers of an edge and an area there are, those of legends among them."""
    return len(places_of(picture, stroke=stroke, fill=fill))


def places_of(picture: Picture, *, fill: str, stroke: str | None = None) -> list[tuple[float, float]]:
    """Return where the markers of an area, and an edge, stand [point]."""
    groups = [one for one in parsed(picture).iter(f"{SVG}g") if one.get("transform") is None]
    mine = [one for one in groups if one.get("fill") == fill and stroke in {None, one.get("stroke")}]
    marks = [mark for one in mine for mark in one.findall(f"{SVG}use")]
    return [(float(mark.get("x", "nan")), float(mark.get("y", "nan"))) for mark in marks]


def lines(picture: Picture, *, stroke: str, dashed: bool | None = None) -> list[str]:
    """Return the paths of a colour, those of legends among them."""
    mine = [one for one in parsed(picture).iter(f"{SVG}path") if one.get("stroke") == stroke]
    return [one.get("d", "") for one in mine if dashed is None or (one.get("stroke-dasharray") is not None) == dashed]


def areas(picture: Picture, *, fill: str) -> list[str]:
    return [one.get("d", "") for one in parsed(picture).iter(f"{SVG}path") if one.get("fill") == fill]


def photographs(picture: Picture) -> list[np.ndarray]:
    packed = [one.get("href", "").partition(",")[2] for one in parsed(picture).iter(f"{SVG}image")]
    return [np.asarray(Image.open(io.BytesIO(base64.b64decode(one))).convert("RGB"), float) for one in packed]
