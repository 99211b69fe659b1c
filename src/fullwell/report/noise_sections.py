"""The chapters on noise without light: read noise, row and column noise, dark signal."""

from fullwell.report import plots_dark
from fullwell.report.material import Material, Section, course, drawn


def read_noise(material: Material) -> Section:
    """Return the chapter on read noise."""
    table = material.table("read_noise_iso")
    pivots = material.pivots(
        ("read_noise", "DN"),
        ("read_noise", "e-"),
        ("read_noise", "V"),
        ("read_noise_pre", "DN"),
        ("read_noise_post", "DN"),
    )
    return Section(
        anchor="read-noise",
        title="Read noise",
        lead="Temporal noise of a pixel that sees no light, the rounding of the converter removed.",
        pictures=drawn(table, plots_dark.read_noise_against_iso),
        pivots=pivots,
        missing="" if pivots or table else "No read noise: capture a burst of bias or short dark frames at each ISO.",
    )


def lines(material: Material) -> Section:
    """Return the chapter on row and column noise."""
    wanted = (
        ("read_noise_row", "DN"),
        ("read_noise_column", "DN"),
        ("read_noise_row", "e-"),
        ("read_noise_column", "e-"),
    )
    return Section(
        anchor="row-column-noise",
        title="Row and column noise",
        lead=(
            "The part of the temporal noise that a whole row or column shares. The eye finds it long before it "
            "reaches the noise of the pixels."
        ),
        pictures=course(
            material,
            "Noise that a whole row or column shares, against ISO. Bars: 95 % interval; a marker at zero with a bar "
            "above it is an upper limit.",
            ("read_noise_row", "DN"),
            ("read_noise_column", "DN"),
        ),
        pivots=material.pivots(*wanted),
    )


def dark_signal(material: Material) -> Section:
    """Return the chapter on dark signal and dark current."""
    table = material.table("dark_signal")
    return Section(
        anchor="dark-current",
        title="Dark signal and dark current",
        lead="What collects without light: the mean of the dark frames against exposure time, and its slope.",
        pictures=drawn(table, plots_dark.dark_signal),
        pivots=material.pivots(("dark_current", "DN/s"), ("dark_current", "e-/s"), ("dark_current", "V/s")),
        missing=(
            "" if table else "No dark current: capture dark bursts at three or more exposures, the longest possible."
        ),
    )
