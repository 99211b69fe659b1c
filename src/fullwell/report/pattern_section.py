"""The chapter on fixed pattern: what differs from pixel to pixel and stays."""

from fullwell.report.material import Material, Section


def fixed_pattern(material: Material) -> Section:
    """Return the chapter on DSNU and PRNU."""
    return Section(
        anchor="nonuniformity",
        title="Fixed pattern",
        lead="What differs from pixel to pixel and stays from frame to frame, in the dark and under light.",
        pivots=material.pivots(("dsnu", "DN"), ("dsnu", "e-"), ("prnu", "%")),
    )
