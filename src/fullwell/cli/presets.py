"""``fullwell presets``: how headerless files of an extension are stored, said once."""

import json
import sys
from dataclasses import asdict
from typing import Annotated

import typer

from fullwell.cli.options import Headerless, Json, Quiet, Verbose, Version
from fullwell.cli.status import guarded

_CONTEXT = {"help_option_names": ["-h", "--help"]}

presets = typer.Typer(rich_markup_mode=None, add_completion=False, pretty_exceptions_enable=False)

Extension = Annotated[str, typer.Argument(metavar="EXTENSION", help="For example raw or bin; no standard one.")]


@presets.callback(invoke_without_command=True)
def everything(context: typer.Context, *, _version: Version = False) -> None:
    """Keep how headerless files are stored, by extension."""
    if context.invoked_subcommand is None:
        sys.stderr.write(context.get_help() + "\n")
        raise typer.Exit(2)


@presets.command("list", help="Show what is kept.", context_settings=_CONTEXT)
def show(*, as_json: Json = False, verbose: Verbose = False, _version: Version = False) -> None:
    """Show what is kept."""
    with guarded(verbose=verbose):
        from fullwell.raw.presets import presets_path, read_presets  # noqa: PLC0415 - `--help` does not need it

        known = read_presets()
        if as_json:
            document = {extension: asdict(stated) for extension, stated in known.items()}
            sys.stdout.write(json.dumps(document, indent=1) + "\n")
        elif known:
            width = max(map(len, known))
            sys.stdout.writelines(f"{extension:<{width}}  {stated}\n" for extension, stated in known.items())
        else:
            sys.stdout.write(f"No presets ({presets_path()}). Keep one with: fullwell presets save EXTENSION FORMAT\n")


@presets.command(help="Keep a format for an extension.", context_settings=_CONTEXT)
def save(
    extension: Extension,
    stated: Annotated[
        str | None,
        typer.Argument(metavar="FORMAT", help="As --headerless takes it: width=1920,height=1080,..."),
    ] = None,
    *,
    headerless: Headerless = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Keep a format for an extension."""
    with guarded(verbose=verbose):
        from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it
        from fullwell.raw.headerless_format import EXAMPLE, parse_format  # noqa: PLC0415 - as above
        from fullwell.raw.presets import extension_from, save_preset  # noqa: PLC0415 - as above

        name = extension_from(extension)
        if (stated is None) == (headerless is None):
            raise UsageError(f"Say once how files with the extension {name} are stored, for example {EXAMPLE}.")
        kept = parse_format(stated or headerless or "", where="FORMAT" if stated else "--headerless")
        path = save_preset(name, kept)
        if not quiet:
            sys.stdout.write(f"Files with the extension {name} are read as {kept} (kept in {path}).\n")


@presets.command(help="Forget the format of an extension.", context_settings=_CONTEXT)
def remove(extension: Extension, *, quiet: Quiet = False, verbose: Verbose = False, _version: Version = False) -> None:
    """Forget the format of an extension."""
    with guarded(verbose=verbose):
        from fullwell.raw.presets import extension_from, remove_preset  # noqa: PLC0415 - `--help` does not need it

        path = remove_preset(extension)
        if not quiet:
            sys.stdout.write(f"Forgot how files with the extension {extension_from(extension)} are stored ({path}).\n")
