"""The chapters on noise without light: read noise, row and column noise, dark signal."""

from scipy.special import chdtrc

from fullwell.fit.constancy import constancy
from fullwell.report import plots_dark, plots_noise
from fullwell.report.curves import Table
from fullwell.report.material import Material, Part, Section, course, drawn, parts_shown
from fullwell.units import DN, Measured


def read_noise(material: Material) -> Section:
    """Return the chapter on read noise."""
    table = material.table("read_noise_iso")
    regions = material.table("read_noise_regions")
    equal = {} if regions is None else {iso: _equality(part) for iso, part in regions.split("iso")}
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
        parts=parts_shown(
            Part(
                title="By the published flows",
                pictures=drawn(material.table("read_noise_repeats"), plots_noise.published_flows),
            ),
            Part(title="By region", pictures=drawn(regions, lambda found: plots_noise.noise_regions(found, equal))),
        ),
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
        pictures=(
            *drawn(table, plots_dark.dark_signal),
            *drawn(material.table("dark_current_temperature"), plots_dark.dark_current_over_temperature),
            *course(
                material,
                "Dark current against ISO, with 95 % intervals: in raw values it grows with the amplification, in "
                "electrons it should not.",
                ("dark_current", "DN/s"),
                ("dark_current", "e-/s"),
            ),
        ),
        pivots=material.pivots(
            ("dark_current", "DN/s"), ("dark_current", "e-/s"), ("dark_current", "V/s"), ("dark_current_doubling", "K")
        ),
        missing=(
            "" if table else "No dark current: capture dark bursts at three or more exposures, the longest possible."
        ),
    )


def _equality(regions: Table) -> float:
    """Return the probability of such differences if every region of a channel had one noise, channels together."""
    chi_square, dof = 0.0, 0
    for _, part in regions.split("channel"):
        noises = [
            Measured.normal(value, error, DN)
            for value, error in zip(part.numbers("read_noise"), part.numbers("std_error"), strict=True)
            if value > 0.0 and error > 0.0
        ]
        if len(noises) > 1:
            same = constancy(noises)
            chi_square, dof = chi_square + same.chi_square, dof + same.dof
    return float(chdtrc(dof, chi_square)) if dof else 1.0
