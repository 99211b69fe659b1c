"""Presets: how headerless files of an extension are stored, said once and kept with the user's settings (RESULTS 5).

They stand in one TOML file, a table for each extension::

    [bin]
    width = 1920
    height = 1080
    bits = 12

The environment variable ``FULLWELL_PRESETS`` names another file.
"""

import os
import sys
import tempfile
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Final, cast

from fullwell.errors import UsageError
from fullwell.raw.headerless_format import HeaderlessFormat, format_from, format_lines

VARIABLE: Final = "FULLWELL_PRESETS"
STANDARD_EXTENSIONS: Final = frozenset(
    {
        *("dng", "tif", "tiff", "png", "jpg", "jpeg", "jpe", "jp2", "jxl", "heic", "heif", "avif", "gif", "bmp"),
        *("webp", "exr", "hdr", "psd", "fits", "fit", "fts", "npy", "npz", "pgm", "ppm", "pnm", "pbm", "pam"),
        *("3fr", "ari", "arw", "cap", "cr2", "cr3", "crw", "dcr", "dcs", "drf", "erf", "fff", "gpr", "iiq", "k25"),
        *(
            "kc2",
            "kdc",
            "mdc",
            "mef",
            "mos",
            "mrw",
            "nef",
            "nrw",
            "orf",
            "ori",
            "pef",
            "ptx",
            "raf",
            "rw2",
            "rwl",
            "sr2",
        ),
        *("srf", "srw", "sti", "x3f", "json", "toml", "txt", "csv", "md", "xml", "xmp", "html", "pdf", "zip"),
    }
)
"""Extensions of formats that say for themselves how they are stored; no preset may claim them."""


def presets_path() -> Path:
    """Return the file of presets: ``FULLWELL_PRESETS``, or where the platform keeps a user's settings."""
    named = os.environ.get(VARIABLE, "").strip()
    if named:
        return Path(named)
    return _settings_folder() / "fullwell" / "presets.toml"


def _settings_folder() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("APPDATA") or Path.home() / "AppData" / "Roaming")
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support"
    return Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config")


def read_presets(path: Path | None = None) -> dict[str, HeaderlessFormat]:
    """Return the presets by extension, sorted; none where there is no file.

    Raises
    ------
    UsageError
        Where the file cannot be read or says something that is not allowed.

    """
    where = path or presets_path()
    try:
        document = tomllib.loads(where.read_text(encoding="utf-8-sig"))
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except OSError as error:
        raise UsageError(f"Cannot read the presets in {where}: {error.strerror}.") from error
    except ValueError as error:
        raise UsageError(f"The presets in {where} are not valid TOML: {error}. Correct or delete the file.") from error
    found: dict[str, HeaderlessFormat] = {}
    for extension, table in sorted(document.items()):
        if not isinstance(table, dict):
            raise UsageError(f"{where}: {extension} is no table; presets are tables such as [bin].")
        values = cast("Mapping[str, object]", table)
        found[extension_from(extension)] = format_from(values, where=f"{where}: [{extension}]")
    return found


def preset_for(path: Path) -> HeaderlessFormat | None:
    """Return the preset for a file's extension, None where there is none.

    Raises
    ------
    UsageError
        As `read_presets`.

    """
    extension = path.suffix.lower().removeprefix(".")
    return read_presets().get(extension) if extension else None


def save_preset(extension: str, stated: HeaderlessFormat, path: Path | None = None) -> Path:
    """Keep a format for an extension, in place of what was kept for it, and return the file.

    Raises
    ------
    UsageError
        Where the extension is a standard one, or the presets that are there cannot be read.

    """
    where = path or presets_path()
    _write({**read_presets(where), extension_from(extension): stated}, where)
    return where


def remove_preset(extension: str, path: Path | None = None) -> Path:
    """Forget the format of an extension, and return the file.

    Raises
    ------
    UsageError
        Where there is none.

    """
    where = path or presets_path()
    presets, name = read_presets(where), extension_from(extension)
    if name not in presets:
        known = f"there are presets for {', '.join(presets)}" if presets else "there are no presets"
        raise UsageError(f"There is no preset for {name}; {known}.")
    del presets[name]
    _write(presets, where)
    return where


def extension_from(text: str) -> str:
    """Return an extension in lower case, without its dot.

    Raises
    ------
    UsageError
        Where it is a standard one, or none at all.

    Examples
    --------
    >>> extension_from(".RAW")
    'raw'

    """
    extension = text.strip().lower().removeprefix(".")
    if not extension or not all(letter.isalnum() or letter in "_-" for letter in extension):
        raise UsageError(f"{text!r} is no file extension; give one such as raw or bin.")
    if extension in STANDARD_EXTENSIONS:
        raise UsageError(
            f"{extension} is the extension of a standard format, whose files say for themselves how they are stored; "
            "give headerless files another one, such as raw or bin."
        )
    return extension


def _write(presets: Mapping[str, HeaderlessFormat], path: Path) -> None:
    """Write the file whole or not at all."""
    lines = ["# How headerless raw files are stored, by extension; kept by `fullwell presets`."]
    for extension, stated in sorted(presets.items()):
        lines += ["", f"[{extension}]", *format_lines(stated)]
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
