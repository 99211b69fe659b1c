"""What a frame was taken for, told by the name of its folder (RESULTS 1)."""

from typing import Final

from fullwell.frames.series import Kind

_BLANKS: Final = str.maketrans("", "", "_- \t")
_PREFIXES: Final = (
    (Kind.DARK, ("dark", "flatdark")),
    (Kind.BIAS, ("bias", "readnoise")),
    (Kind.FLAT, ("flat", "prnu", "bright", "light")),
    (Kind.CHART, ("chart",)),
    (Kind.SCENE, ("scene",)),
)
_SCENE_NAME: Final = "interesting"


def kind_of_folder(name: str) -> Kind | None:
    """Return the kind a folder's name stands for, without regard to case, ``_``, ``-`` and blanks.

    Examples
    --------
    >>> kind_of_folder("Flat_Dark 20C")
    <Kind.DARK: 'dark'>
    >>> kind_of_folder("PRNU_DSNU")
    <Kind.FLAT: 'flat'>
    >>> kind_of_folder("notes") is None
    True

    """
    plain = name.casefold().translate(_BLANKS)
    for kind, prefixes in _PREFIXES:
        if plain.startswith(prefixes):
            return kind
    return Kind.SCENE if plain == _SCENE_NAME else None
