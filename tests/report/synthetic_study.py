"""What every part of the synthetic study shares: its ISOs, channels and exposures, and how a row is written."""

from fullwell.figures.results import Column, Curve, Row

ISOS = (55.0, 99.0, 198.0, 299.0, 395.0, 798.0)
RESPONSE = {"R": 0.5, "G1": 1.0, "G2": 0.99, "B": 0.62}
FLAT_EXPOSURES = (0.002, 0.004, 0.008, 0.016, 0.03)
DARK_EXPOSURES = (0.01, 0.02, 0.04, 0.08, 0.16)
PIXELS = 762048


def gain_at(iso: float) -> float:
    return 0.1705 * iso / 55.0


def row(quantity, channel, method, measured, **others):
    return Row(quantity=quantity, channel=channel, method=method, measured=measured, source="METHOD 3.1", **others)


def curve(name: str, columns: dict[str, str], points: list[tuple]) -> Curve:
    values = list(zip(*points, strict=True)) if points else [()] * len(columns)
    return Curve(
        name=name,
        columns=tuple(
            Column(name=column, unit=unit, values=tuple(one))
            for (column, unit), one in zip(columns.items(), values, strict=True)
        ),
    )
