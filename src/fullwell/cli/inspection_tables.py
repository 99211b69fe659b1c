"""What was told about raw files, as a panel, a table, or objects for JSON (RESULTS 5)."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Final

from rich.console import Console
from rich.markup import escape
from rich.panel import Panel
from rich.table import Table

from fullwell.cli.tables import plain_table, print_findings, spelled_levels, spelled_values
from fullwell.raw.image import Levels, RawHeader
from fullwell.report.numbers import show_exposure
from fullwell.workflow.inspection import Inspection
from fullwell.workflow.signs.content import Content

_PIPED_WIDTH: Final = 240
"""Most columns of a table that goes into a file or another program, where no name should be broken [character]."""


def document(inspection: Inspection) -> Mapping[str, object]:
    """Return the object of one file; a file that cannot be read has nulls and its findings."""
    header = inspection.header
    return {
        "path": str(inspection.path),
        "format": header and header.format,
        "make": header and header.make,
        "model": header and header.model,
        "width": header and header.width,
        "height": header and header.height,
        "raw_width": header and header.raw_width,
        "raw_height": header and header.raw_height,
        "active_area": header and list(header.active_area),
        "cfa": header and header.cfa,
        "bit_depth": header and header.bit_depth,
        "effective_bits": inspection.effective_bits,
        "black_level": header and header.black_level and list(header.black_level.values),
        "white_level": header and _white(header.white_level),
        "iso": header and header.iso,
        "exposure_s": header and header.exposure_s,
        "compression": header and header.compression,
        "masked_areas": [list(area) for area in header.masked_areas] if header else [],
        "noise_profile": [list(plane) for plane in header.noise_profile] if header else [],
        "level_tags": {name: list(values) for name, values in header.level_tags} if header else {},
        **_content(inspection.content),
        "findings": [asdict(replace(finding, files=(str(inspection.path),))) for finding in inspection.findings],
    }


def _content(content: Content | None) -> Mapping[str, object]:
    """Return what the pixels tell, per CFA site where there are several."""
    if content is None:
        return {}
    return {
        "lowest_code": [use.lowest for use in content.uses],
        "highest_code": [use.highest for use in content.uses],
        "clips_at": [white.seen if white.piles_up else None for white in content.whites],
        "code_step": [use.scale for use in content.uses],
        "code_pattern": [use.pattern.value for use in content.uses],
        "missing_codes": [list(use.missing) for use in content.uses],
        "optical_black": [
            {
                "channel": area.channel,
                "mean_dn": area.mean_dn,
                "std_error_dn": area.std_error_dn,
                "variance_dn2": area.variance_dn2,
                "n": area.n,
            }
            for area in content.masked
        ],
        "cfa_content": list(content.order.order.names),
        "isolated_pixels": {"above": len(content.isolated.above), "below": len(content.isolated.below)},
    }


def _white(levels: Levels | None) -> float | list[float] | None:
    if levels is None:
        return None
    return levels.values[0] if len(set(levels.values)) == 1 else list(levels.values)


def print_panel(console: Console, inspection: Inspection) -> None:
    """Print everything about one file."""
    if inspection.header is not None:
        grid = Table.grid(padding=(0, 2))
        for name, value in _facts(inspection.header, inspection.content):
            grid.add_row(name, escape(value))
        console.print(Panel(grid, title=escape(str(inspection.path)), expand=False), highlight=False)
    else:
        console.print(escape(str(inspection.path)), highlight=False)
    print_findings(console, inspection.findings)


def _facts(header: RawHeader, content: Content | None) -> Iterator[tuple[str, str]]:
    yield "format", f"{header.format}, compression {header.compression}"
    yield "camera", header.camera or "unknown"
    yield "visible", f"{header.width} x {header.height} pixels"
    area = header.active_area
    yield "stored", f"{header.raw_width} x {header.raw_height}, active area from row {area.top}, column {area.left}"
    yield "CFA", header.cfa or "unknown: the file does not say"
    effective_bits = None if content is None else content.effective_bits
    used = "unknown" if effective_bits is None else str(effective_bits)
    yield "bits", f"{header.bit_depth} declared, {used} used"
    yield "black level", spelled_levels(header.black_level)
    yield "white level", spelled_levels(header.white_level)
    yield from ((name, spelled_values(values)) for name, values in header.level_tags)
    yield "ISO", "unknown" if header.iso is None else f"{header.iso:g}"
    yield "exposure", "unknown" if header.exposure_s is None else show_exposure(header.exposure_s)
    if header.temperature_c is not None:
        yield "temperature", f"{header.temperature_c:g} °C"
    for masked in header.masked_areas:
        yield "masked area", f"rows {masked.top} to {masked.bottom}, columns {masked.left} to {masked.right}"
    if content is not None:
        yield from _told(content)
    for scale, offset in header.noise_profile:
        yield "noise profile", f"S {scale:.6g}, O {offset:.6g}"


def _told(content: Content) -> Iterator[tuple[str, str]]:
    """Yield what the pixels tell."""
    if content.masked:
        levels = ", ".join(f"{area.channel} {area.mean_dn:.2f} ± {area.std_error_dn:.2f}" for area in content.masked)
        yield "optical black", f"{levels} DN"
    whites = zip(content.channels, content.uses, content.whites, strict=True)
    codes = [f"{name} {use.lowest} to {use.highest}{' (clips)' * white.piles_up}" for name, use, white in whites]
    yield "codes", ", ".join(codes)
    if content.order.order.names:
        yield "CFA by content", " or ".join(content.order.order.names)


def print_table(console: Console, inspections: Sequence[Inspection]) -> None:
    """Print one line per file, then what there is to say about them."""
    names = [one.path.name for one in inspections]
    table = plain_table("file", "format", ">size", "CFA", ">bits", ">black", ">white", ">ISO", ">exposure")
    for one in inspections:
        header, name = one.header, one.path.name if names.count(one.path.name) < 2 else str(one.path)
        if header is None:
            table.add_row(escape(name), "unreadable")
            continue
        table.add_row(
            escape(name),
            header.format,
            f"{header.width} x {header.height}",
            header.cfa or "?",
            str(header.bit_depth if one.effective_bits is None else one.effective_bits),
            "?" if header.black_level is None else spelled_values(header.black_level.values),
            "?" if header.white_level is None else spelled_values(header.white_level.values),
            "?" if header.iso is None else f"{header.iso:g}",
            "?" if header.exposure_s is None else show_exposure(header.exposure_s),
        )
    if not console.is_terminal:
        console.width = _PIPED_WIDTH
    console.print(table)
    print_findings(
        console, [replace(finding, files=(str(one.path),)) for one in inspections for finding in one.findings]
    )
