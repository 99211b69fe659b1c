"""The chapter on fixed pattern: what differs from pixel to pixel and stays."""

from collections.abc import Sequence
from typing import Final

from fullwell.figures.results import Row
from fullwell.fit.pooling import SIGNIFICANCE
from fullwell.raw.cfa import channel_rank
from fullwell.report import plots_pattern
from fullwell.report.comparison import LEGACY
from fullwell.report.curves import Table, Value
from fullwell.report.material import (
    Material,
    Part,
    Section,
    Tab,
    WordTable,
    drawn,
    iso_tabs,
    over_isos,
    parts_shown,
)
from fullwell.report.numbers import MISSING, show_iso, show_plain, show_unit
from fullwell.report.pivots import title_of
from fullwell.report.plots import Picture

_SLOPES: Final = "legacy-slope-std"
_SAME: Final = 0.05


def fixed_pattern(material: Material) -> Section:
    """Return the chapter on DSNU and PRNU."""
    pivots = material.pivots(("prnu", "%"), ("dsnu", "DN"), ("dsnu", "e-"), ("dsnu", "V"))
    published = [row for row in material.results.rows if row.method.startswith(LEGACY)]
    parts = parts_shown(
        Part(title="PRNU of each channel", pictures=_channels(material, published)),
        Part(title="Against ISO", pictures=_course(material, published), tables=_constancy(material)),
        Part(
            title="Rows, columns, pixels",
            lead="The squares of the three parts add up to that of the whole, but for their errors." if pivots else "",
            pivots=material.pivots(*_parts("prnu", "%"), *_parts("dsnu", "DN")),
        ),
        Part(title="PRNU of each tile", tabs=_tiles(material)),
        Part(title="Response of the pixels", tabs=_responses(material)),
        Part(
            title="Standard deviation against exposure",
            pictures=drawn(material.table("std_exposure"), plots_pattern.std_against_exposure),
        ),
    )
    return Section(
        anchor="nonuniformity",
        title="Fixed pattern",
        lead="What differs from pixel to pixel and stays from frame to frame, in the dark and under light.",
        pivots=pivots,
        parts=parts,
        missing=_missing(material),
    )


def _parts(quantity: str, unit: str) -> tuple[tuple[str, str], ...]:
    return tuple((f"{quantity}_{part}", unit) for part in ("row", "column", "pixel"))


def _missing(material: Material) -> str:
    """Say which capture is missing for PRNU or DSNU."""
    measured = {row.quantity for row in material.rows}
    wanted = {
        "prnu": "No PRNU: capture bursts of evenly lit flat frames, at several exposures or with dark frames beside.",
        "dsnu": "No DSNU: capture bursts of dark frames.",
    }
    return " ".join(text for quantity, text in wanted.items() if quantity not in measured)


def _channels(material: Material, published: Sequence[Row]) -> tuple[Picture, ...]:
    best = [row for row in material.rows if (row.quantity, row.measured.unit) == ("prnu", "%")]
    slopes = [row for row in published if row.method == _SLOPES]
    whole = [row for row in slopes if row.region is not None]
    tiles = [row for row in slopes if row.region is None]
    return (plots_pattern.by_channel(best, whole, tiles),) if best or slopes else ()


def _course(material: Material, published: Sequence[Row]) -> tuple[Picture, ...]:
    several = over_isos(material)
    panels = {
        (title_of(quantity), unit): [row for rows in several[(quantity, unit)].values() for row in rows]
        for quantity, unit in (("prnu", "%"), ("dsnu", "DN"), ("dsnu", "e-"))
        if (quantity, unit) in several
    }
    old = [row for row in published if row.region is None and row.channel != "all"]
    return (plots_pattern.against_iso(panels, old),) if panels else ()


def _tiles(material: Material) -> tuple[Tab, ...]:
    published = material.table("prnu_tiles_legacy")
    old: dict[Value, Table] = dict(published.split("iso")) if published is not None else {}

    def draw(table: Table, iso: Value) -> Picture:
        pooled = {
            row.channel: row
            for row in material.rows
            if (row.quantity, row.measured.unit, row.iso) == ("prnu", "%", iso)
        }
        return plots_pattern.per_tile(table, old.get(iso), pooled, iso)

    return iso_tabs(material.table("prnu_tiles"), draw)


def _responses(material: Material) -> tuple[Tab, ...]:
    pictures = material.pictures.responses
    isos = sorted({picture.iso for picture in pictures}, key=lambda iso: -1.0 if iso is None else iso)
    groups = ((iso, [picture for picture in pictures if picture.iso == iso]) for iso in isos)
    return tuple(Tab(label=show_iso(iso), pictures=(plots_pattern.responses(mine),)) for iso, mine in groups)


def _constancy(material: Material) -> tuple[WordTable, ...]:
    """Return what the test of equality over ISOs says, in words."""
    table = material.table("iso_constancy")
    if table is None:
        return ()
    lines = tuple(
        (
            title_of(str(quantity)),
            str(channel),
            f"{_number(mean)} {show_unit(str(unit))}",
            f"{_number(chi_square)} / {_number(dof)}",
            _probability(p_value),
            _verdict(p_value),
        )
        for quantity, channel, unit, mean, chi_square, dof, p_value in sorted(
            zip(
                *(
                    table.values(name)
                    for name in ("quantity", "channel", "unit", "mean", "chi_square", "dof", "p_value")
                ),
                strict=True,
            ),
            key=lambda line: (str(line[0]), channel_rank(str(line[1]))),
        )
    )
    return (
        WordTable(
            title="Is it the same at every ISO?",
            head=("Figure", "Channel", "Mean over ISOs", "χ² / degrees of freedom", "p", "In words"),
            lines=lines,
            note=(
                "p: probability of differences as large as these if the figure were the same at every ISO. Pixels do "
                "not know the amplifier: PRNU, and DSNU and dark current in electrons, should not depend on it."
            ),
        ),
    )


def _number(value: Value) -> str:
    return show_plain(float(value)) if isinstance(value, (int, float)) else MISSING


def _probability(value: Value) -> str:
    if not isinstance(value, (int, float)):
        return MISSING
    return "< 0.001" if value < 1e-3 else f"{value:.2g}"


def _verdict(p_value: Value) -> str:
    if not isinstance(p_value, (int, float)):
        return "not tested"
    if p_value >= _SAME:
        return "the same at every ISO, as far as the errors can tell"
    return "in doubt: differences this large are rare" if p_value >= SIGNIFICANCE else "not the same at every ISO"
