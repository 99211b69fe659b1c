"""What a conversion changed, and what it could not keep: every bit of it is said."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from fullwell.errors import RawFileError
from fullwell.findings import Finding, Severity
from fullwell.raw.cfa import MONO
from fullwell.raw.opcodes import GainMap
from fullwell.raw.rewriting import read_opcodes
from fullwell.raw.segments import Layout
from fullwell.workflow.convert.recoding import Recoded
from fullwell.workflow.convert.settings import Conversion, FileKind
from fullwell.workflow.convert.writing import whole_iso, written_black
from fullwell.workflow.scenes import Scene


def conversion_findings(scene: Scene, done: Recoded, conversion: Conversion, *, kind: FileKind) -> tuple[Finding, ...]:
    """Return what is to be said about one converted file."""
    said = (
        *_shift(done, conversion),
        *_scale(done),
        *_levels(scene, done),
        *_margins(scene, done),
        *_metadata(scene, done, kind=kind),
        *_coding(scene),
    )
    return tuple(replace(one, files=(str(scene.path),)) for one in said)


def _shift(done: Recoded, conversion: Conversion) -> Iterator[Finding]:
    if done.shifted_out:
        bits = -conversion.bit_shift
        mean_loss_dn = (2**bits - 1) / 2 ** (bits + 1)
        yield _warning(
            "bits-shifted-out",
            f"{_share(done.shifted_out, done.codes.mosaic.size)} of the codes had bits set among the {bits} that were "
            f"shifted out and were rounded down, by {mean_loss_dn:g} DN of the new scale on average where low bits are "
            "random.",
        )


def _scale(done: Recoded) -> Iterator[Finding]:
    clipped = done.clipped
    if clipped is not None and clipped.below:
        yield _warning(
            "clipped-at-black",
            f"{_share(clipped.below, clipped.of)} of the samples lay below black and are 0 now: that is lost, and "
            "dark noise measured in the new file reads too low.",
        )
    if clipped is not None and clipped.above:
        message = f"{_share(clipped.above, clipped.of)} of the samples lay above white and are 65535 now."
        yield _info("clipped-at-white", message)
    if done.rgb is not None:
        message = "Colours were interpolated: the new file is a picture, whose noise is no longer the sensor's."
        yield _warning("demosaicked", message)
    if done.neutral:
        factors = ", ".join(f"{max(done.neutral) / one:.4g}" for one in done.neutral)
        message = f"Red, green and blue were multiplied by {factors}: codes are no longer what the sensor gave."
        yield _warning("white-balanced", message)


def _levels(scene: Scene, done: Recoded) -> Iterator[Finding]:
    white = scene.white_level
    if white.source == "default" and scene.header.white_level is None:
        yield _info(
            "white-level-assumed",
            f"Nothing says its white level; the highest code of {scene.bit_depth} bits, {white.values[0]:g} DN, was "
            "taken. Give its own with --white.",
        )
    if written_black(scene, done) is None:
        yield _info(
            "black-level-unknown",
            "Nothing says its black level, so none was written, for which readers take 0. Give its own with --black.",
        )
    if len(set(white.values)) > 1:
        yield _info(
            "white-level-per-site",
            "Its white level differs between CFA sites, which DNG cannot say; the lowest was written there.",
        )


def _margins(scene: Scene, done: Recoded) -> Iterator[Finding]:
    header, area = scene.header, done.area
    if (header.height, header.width) == (header.raw_height, header.raw_width):
        return
    if area == header.active_area:
        message = "The visible mosaic was written; the margins around it, optical black among them, were left out."
        yield _info("margins-left-out", message)
        return
    trimmed = [name for name, gone in (("row", area.top), ("column", area.left)) if gone]
    if trimmed:
        yield _info(
            "margin-trimmed",
            f"The first {' and the first '.join(trimmed)} of the margins was left out: LibRaw reads a mosaic that "
            "begins at an odd place one pixel off.",
        )
    if header.masked_areas and header.format != "dng":
        yield _info(
            "masked-areas-unnamed",
            "The margins were kept around the visible mosaic without being named MaskedAreas: LibRaw would take their "
            "mean for the black level.",
        )


def _metadata(scene: Scene, done: Recoded, *, kind: FileKind) -> Iterator[Finding]:
    header = scene.header
    if header.iso is not None and header.iso != whole_iso(header.iso):
        where = " in the TIFF; its sidecar has it all" if kind == "tiff" and done.rgb is None else ""
        message = f"EXIF has whole ISO speeds only: {header.iso:g} became {whole_iso(header.iso):g}{where}."
        yield _info("iso-rounded", message)
    if header.noise_profile and (done.rgb is not None or done.neutral):
        message = "Its NoiseProfile does not hold for what was written and was left out."
        yield _info("noise-profile-left-out", message)
    if kind == "tiff" and header.colour_matrix is not None and scene.cfa != MONO:
        yield _info("colour-matrix-left-out", "TIFF has no place for its colour matrix.")
    others = [
        f"{name} {' '.join(f'{value:g}' for value in values)}"
        for name, values in header.level_tags
        if not any(word in name.casefold() for word in ("black", "white", "maximum"))
    ]
    if others:
        yield _info("level-tags-left-out", f"There is no tag for its {', '.join(others)}.")


def _coding(scene: Scene) -> Iterator[Finding]:
    header = scene.header
    if isinstance(header.layout, Layout) and header.layout.table:
        message = "Its LinearizationTable was applied: the new file holds linear codes."
        yield _info("linearization-applied", message)
    names = _opcodes(scene)
    if names:
        yield _info("opcodes-left-out", f"Its opcodes were neither applied nor kept: {', '.join(names)}.")


def _opcodes(scene: Scene) -> Sequence[str]:
    """Return what the opcode lists of a DNG hold, in words."""
    if scene.header.format != "dng":
        return ()
    try:
        lists = read_opcodes(scene.path)
    except RawFileError:
        return ("they cannot be read",)
    return [
        f"{name.name} with {len(opcodes)}, of which {sum(isinstance(one, GainMap) for one in opcodes)} gain maps"
        for name, opcodes in lists.items()
        if opcodes
    ]


def _share(count: int, of: int) -> str:
    return f"{count} of {of} ({100.0 * count / of:.3g} %)"


def _info(code: str, message: str) -> Finding:
    return Finding(code=code, severity=Severity.INFO, message=message)


def _warning(code: str, message: str) -> Finding:
    return Finding(code=code, severity=Severity.WARNING, message=message)
