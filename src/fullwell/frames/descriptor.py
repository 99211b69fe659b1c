"""Descriptor files of the ``emva1288`` package (EMVA1288 16.1): which images were taken at which exposure and light.

``v``, ``n``, ``b``, ``d`` and ``i`` lines become blocks. Two images are a pair that shows the temporal noise, more are
a stack that shows the fixed pattern. Beyond the package a light sweep may stand beside a dark series of its own. What
is wrong is said with its line.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Final, NoReturn

from fullwell.errors import RawFileError, UsageError
from fullwell.findings import Finding, Severity
from fullwell.frames.campaign import Campaign
from fullwell.frames.series import Camera, Kind, Light
from fullwell.frames.source import Candidate, Given, Source
from fullwell.raw.image import RawHeader
from fullwell.raw.open import read_headers

_PER_SECOND: Final = 1e9
_ARGUMENTS: Final = {
    "v": "version",
    "n": "bits width height",
    "b": "exposure_ns photons",
    "d": "exposure_ns",
    "i": "image",
}
_MOST_BITS: Final = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Images of one exposure and light.

    Parameters
    ----------
    line
        Where it begins, from 1.
    exposure_ns
        [ns].
    photons
        Mean photons per pixel; 0 in the dark.
    images
        As written, each with its line.

    """

    line: int
    exposure_ns: float
    photons: float
    images: tuple[tuple[int, str], ...] = ()

    @property
    def stack(self) -> bool:
        """Return whether the package takes it for spatial data."""
        return len(self.images) > 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Descriptor:
    """What a descriptor file says.

    Parameters
    ----------
    version
        As stated.
    bits, width, height
        None where no ``n`` line says it.
    blocks
        In the file's order.
    unknown
        Lines with a letter nobody knows, which are passed over: number and text.

    """

    version: str | None
    bits: int | None
    width: int | None
    height: int | None
    blocks: tuple[Block, ...]
    unknown: tuple[tuple[int, str], ...] = ()


def is_descriptor(path: Path) -> bool:
    """Tell whether a file reads like a descriptor: its first line with a content is one of its kinds."""
    try:
        with path.open(encoding="utf-8-sig") as file:
            text = file.read(4096)
    except (OSError, UnicodeDecodeError):
        return False
    lines = (line.split() for line in text.splitlines())
    first = next((tokens for tokens in lines if tokens and not tokens[0].startswith("#")), [])
    return len(first) > 1 and first[0] in _ARGUMENTS


def parse_descriptor(path: Path) -> Descriptor:
    """Read a descriptor.

    Raises
    ------
    UsageError
        With the line and what is wrong in it.

    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise UsageError(f"Cannot read {path}: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path} is not a text file in UTF-8: {error.reason} at byte {error.start}.") from error
    parser = _Parser(path)
    for number, line in enumerate(text.splitlines(), start=1):
        tokens = line.split()
        if tokens and not tokens[0].startswith("#"):
            parser.take(number, tokens)
    return parser.descriptor()


class _Parser:
    """Reads line after line."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._version: str | None = None
        self._format: tuple[int, int, int] | None = None
        self._blocks: list[Block] = []
        self._unknown: list[tuple[int, str]] = []
        self._open = False

    def take(self, line: int, tokens: Sequence[str]) -> None:
        """Take one line with a content."""
        letter, *values = tokens
        wish = _ARGUMENTS.get(letter)
        if wish is None:
            if not values:
                self._refuse(line, f'"{letter}" stands alone; a line has a letter and its values')
            self._unknown.append((line, " ".join(tokens)))
            self._open = False
            return
        if len(values) != len(wish.split()):
            hint = "; blanks in paths are not allowed" if letter == "i" and values else ""
            self._refuse(line, f'"{" ".join(tokens)}" should be "{letter} {wish}"{hint}')
        if letter == "i":
            self._image(line, values[0])
            return
        self._open = letter in "bd"
        if letter == "v":
            self._version = values[0]
        elif letter == "n":
            self._stored(line, values)
        else:
            exposure_ns = self._number(line, values[0], "the exposure")
            photons = self._number(line, values[1], "the number of photons") if letter == "b" else 0.0
            self._blocks.append(Block(line=line, exposure_ns=exposure_ns, photons=photons))

    def _image(self, line: int, name: str) -> None:
        if name[0] in "\"'" and name[-1] == name[0]:
            self._refuse(line, f"{name} stands in quotation marks, which would be part of its name; leave them out")
        if not self._open:
            self._refuse(line, "an image must follow a b or d line, or another image")
        last = self._blocks[-1]
        self._blocks[-1] = replace(last, images=(*last.images, (line, name)))

    def _stored(self, line: int, values: Sequence[str]) -> None:
        if self._format is not None:
            self._refuse(line, 'only one "n bits width height" is allowed')
        try:
            bits, width, height = (int(value) for value in values)
        except ValueError:
            self._refuse(line, f'"n {" ".join(values)}" should hold three whole numbers: bits, width, height')
        if not (1 <= bits <= _MOST_BITS and width > 0 and height > 0):
            self._refuse(line, f"images have 1 to {_MOST_BITS} bits and a size, not {bits} bits, {width} x {height}")
        self._format = (bits, width, height)

    def _number(self, line: int, text: str, what: str) -> float:
        try:
            value = float(text.replace(",", "."))
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value >= 0.0):
            self._refuse(line, f'{what} "{text}" is not a number of 0 or more')
        return value

    def _refuse(self, line: int, reason: str) -> NoReturn:
        raise UsageError(f"{self._path}, line {line}: {reason}.")

    def descriptor(self) -> Descriptor:
        """Return what was read, once it makes sense as a whole."""
        if not self._blocks:
            raise UsageError(f"{self._path} names no images: it should hold b and d lines, each with its i lines.")
        seen: dict[tuple[bool, float, float], int] = {}
        for block in self._blocks:
            if len(block.images) < 2:
                count = "only one image follows" if block.images else "no image follows"
                self._refuse(block.line, f"{count}; a block has two (a pair) or more (a stack)")
            first = seen.setdefault((block.stack, block.exposure_ns, block.photons), block.line)
            if first != block.line:
                what = f"{'stack' if block.stack else 'pair'} at {block.exposure_ns:g} ns and {block.photons:g} photons"
                self._refuse(block.line, f"a {what} stands in line {first} already")
        bits, width, height = self._format or (None, None, None)
        return Descriptor(
            version=self._version,
            bits=bits,
            width=width,
            height=height,
            blocks=tuple(self._blocks),
            unknown=tuple(self._unknown),
        )


def read_descriptor(path: Path) -> Source:
    """Read a descriptor and find its images.

    Parameters
    ----------
    path
        The descriptor; images are relative to its folder. A JSON file of the same stem may hold what it has no place
        for: ``camera``, ``light`` and ``emva`` as in a manifest, ``iso``, ``temperature_c``.

    Raises
    ------
    UsageError
        With the line and what is wrong: a form the format does not have, an image that is missing or has another size,
        an exposure without darks where nothing can stand in for them, photons that do not rise with the exposure.

    """
    descriptor = parse_descriptor(path)
    findings = (*_unknown_lines(path, descriptor), *_dark_findings(path, descriptor))
    _check_photons(path, descriptor)
    facts = _facts_beside(path)
    candidates: dict[str, Candidate] = {}
    for number, block in enumerate(descriptor.blocks):
        given = Given(
            iso=facts.iso,
            temperature_c=facts.temperature_c,
            exposure_s=block.exposure_ns / _PER_SECOND,
            photons=block.photons or None,
            stack=block.stack,
            block=number,
        )
        kind = Kind.FLAT if block.photons > 0.0 else Kind.DARK
        for line, text in block.images:
            name = _image_name(text)
            if name in candidates:
                raise UsageError(f"{path}, line {line}: {name} is listed twice; every frame counts once.")
            candidates[name] = Candidate(name=name, path=path.parent / name, kind=kind, given=given)
    headers = _checked_headers(path, descriptor)
    camera = facts.camera
    ordered = sorted(candidates.values(), key=lambda one: (one.name, one.kind))
    return Source(
        root=path.parent,
        camera=camera if camera.bit_depth else replace(camera, bit_depth=descriptor.bits),
        candidates=tuple(replace(one, headers=headers.get(one.name, ())) for one in ordered),
        findings=findings,
        light=facts.light,
        campaign=facts.campaign,
        descriptor=True,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Facts:
    """What the JSON file beside a descriptor tells."""

    camera: Camera = field(default_factory=Camera)
    light: Light = field(default_factory=Light)
    campaign: Campaign = field(default_factory=Campaign)
    iso: float | None = None
    temperature_c: float | None = None


def _facts_beside(path: Path) -> _Facts:
    beside = path.with_suffix(".json")
    if not beside.is_file():
        return _Facts()
    from fullwell.frames.manifest_tables import DescriptorFacts, validated  # noqa: PLC0415 - pydantic loads when used

    told = validated(DescriptorFacts, beside)
    return _Facts(
        camera=told.camera.camera,
        light=told.light.light,
        campaign=told.emva.campaign,
        iso=told.iso,
        temperature_c=told.temperature_c,
    )


def _image_name(text: str) -> str:
    return Path(text.replace("\\", "/")).as_posix()


def _unknown_lines(path: Path, descriptor: Descriptor) -> tuple[Finding, ...]:
    return tuple(
        Finding(
            code="descriptor-line-unknown",
            severity=Severity.WARNING,
            message=f'{path.name}, line {line}: "{text}" is none of v, n, b, d, i and is passed over.',
        )
        for line, text in descriptor.unknown
    )


def _dark_findings(path: Path, descriptor: Descriptor) -> tuple[Finding, ...]:
    """Return exposures of flats without darks of their kind; refuse where no two others can stand in."""
    findings: list[Finding] = []
    darks = {(block.stack, block.exposure_ns) for block in descriptor.blocks if block.photons == 0.0}
    for block in descriptor.blocks:
        exposures = {exposure for _stack, exposure in darks} if not block.stack else {block.exposure_ns}
        at_hand = (block.stack, block.exposure_ns) in darks
        if block.photons == 0.0 or at_hand or (not block.stack and (True, block.exposure_ns) in darks):
            continue
        sentence = f"line {block.line}: there are no dark images (d {block.exposure_ns:g}) at this exposure"
        if block.stack or len(exposures) < 2:
            raise UsageError(f"{path}, {sentence}.")
        findings.append(
            Finding(
                code="descriptor-no-dark",
                severity=Severity.ERROR,
                message=f"{path.name}, {sentence}; the dark signal is read off a line through the other darks.",
            )
        )
    return tuple(findings)


def _check_photons(path: Path, descriptor: Descriptor) -> None:
    """Refuse photons that do not rise with the exposure where each exposure has one light."""
    for stack in (False, True):
        lit = [block for block in descriptor.blocks if block.photons > 0.0 and block.stack is stack]
        by_exposure = sorted(lit, key=lambda block: block.exposure_ns)
        if len({block.exposure_ns for block in lit}) < len(lit):
            continue
        for before, block in pairwise(by_exposure):
            if block.photons <= before.photons:
                raise UsageError(
                    f"{path}, line {block.line}: {block.photons:g} photons at {block.exposure_ns:g} ns are not more "
                    f"than the {before.photons:g} of the shorter exposure in line {before.line}."
                )


def _checked_headers(path: Path, descriptor: Descriptor) -> dict[str, tuple[RawHeader, ...]]:
    """Return what the images say of themselves, by name, where they can be read.

    Raises
    ------
    UsageError
        An image is missing, or has another size than the n line or the first image says.

    """
    found: dict[str, tuple[RawHeader, ...]] = {}
    said = None if descriptor.width is None else (descriptor.width, descriptor.height)
    by = "the n line"
    for block in descriptor.blocks:
        for line, text in block.images:
            name = _image_name(text)
            try:
                found[name] = read_headers(path.parent / name)
            except RawFileError as error:
                if error.code == "file-missing":
                    raise UsageError(f"{path}, line {line}: the image {name} does not exist.") from error
                continue
            size = (found[name][0].width, found[name][0].height)
            if said is None:
                said, by = size, name
            if size != said:
                raise UsageError(
                    f"{path}, line {line}: {name} has {size[0]} x {size[1]} pixels, {by} says {said[0]} x {said[1]}."
                )
    return found
