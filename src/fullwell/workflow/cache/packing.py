"""Frozen dataclasses become a file and come back: JSON for what they are made of, plain arrays after it.

Nothing in such a file is executed or guessed: what comes back is built from the annotations of the class asked for. A
checksum over all that follows it stands at the front, so that damage is noticed before anything is believed.
"""

import json
import types
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any, BinaryIO, Final, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray
from xxhash import xxh3_128

MAGIC: Final = b"fullwell-packed/1\n"
_DIGEST_BYTES: Final = 16
_START: Final = len(MAGIC) + _DIGEST_BYTES
_LENGTH_BYTES: Final = 8
_ALIGNED: Final = 64
_PIECE: Final = 1 << 20
_PLAIN: Final = (bool, int, float, str)

_T = TypeVar("_T")


class DamagedError(Exception):
    """The file is not what was written."""


def write_packed(file: BinaryIO, value: object) -> None:
    """Write a frozen dataclass into an empty file that can be read and written.

    Fields are None, booleans, numbers, texts, enumerations, arrays of numbers, tuples, mappings with text keys, and
    frozen dataclasses again.
    """
    arrays: list[NDArray[Any]] = []
    tree = _tree(value, arrays)
    offsets = np.cumsum([0, *(_padded(array.nbytes) for array in arrays)])
    listed = [
        {"dtype": array.dtype.newbyteorder("<").str, "shape": array.shape, "at": int(at)}
        for array, at in zip(arrays, offsets, strict=False)
    ]
    text = json.dumps({"value": tree, "arrays": listed}).encode()
    text += b" " * (_padded(_START + _LENGTH_BYTES + len(text)) - _START - _LENGTH_BYTES - len(text))
    digest = xxh3_128()

    def write(data: bytes | memoryview) -> None:
        digest.update(data)
        file.write(data)

    file.write(MAGIC + bytes(_DIGEST_BYTES))
    write(len(text).to_bytes(_LENGTH_BYTES, "little"))
    write(text)
    for array in arrays:
        plain = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
        write(plain.data.cast("B") if plain.size else b"")
        write(bytes(_padded(plain.nbytes) - plain.nbytes))
    file.seek(len(MAGIC))
    file.write(digest.digest())


def read_packed(path: Path, kind: type[_T], *, mapped: int | None = None) -> _T:
    """Return the dataclass a file holds.

    Parameters
    ----------
    path
        The file; it is read through once, to see that it is whole.
    kind
        What was written.
    mapped
        Arrays of at least so many bytes stay in the file and are mapped, read-only; None: none.

    Raises
    ------
    DamagedError
        The file was cut off, or changed, or holds something else.
    OSError
        It cannot be read.

    """
    with path.open("rb") as file:
        front = file.read(_START)
        if front[: len(MAGIC)] != MAGIC or _digest(file) != front[len(MAGIC) :]:
            raise DamagedError(f"{path} is damaged")
        file.seek(_START)
        length = int.from_bytes(file.read(_LENGTH_BYTES), "little")
        document = json.loads(file.read(length))
        first = file.tell()

        def array_at(index: int) -> NDArray[Any]:
            listed = document["arrays"][index]
            dtype, shape, at = np.dtype(listed["dtype"]), tuple(listed["shape"]), first + listed["at"]
            count = int(np.prod(shape, dtype=np.int64))
            if mapped is not None and count * dtype.itemsize >= max(mapped, 1):
                return np.memmap(path, dtype=dtype, mode="r", offset=at, shape=shape).view(np.ndarray)
            file.seek(at)
            found = np.fromfile(file, dtype, count).reshape(shape).astype(dtype.newbyteorder("="), copy=False)
            found.flags.writeable = False
            return found

        try:
            return cast("_T", _value(document["value"], kind, array_at))
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise DamagedError(f"{path} holds something else") from error


def _digest(file: BinaryIO) -> bytes:
    digest = xxh3_128()
    while piece := file.read(_PIECE):
        digest.update(piece)
    return digest.digest()


def _padded(size: int) -> int:
    return -(-size // _ALIGNED) * _ALIGNED


def _tree(value: object, arrays: list[NDArray[Any]]) -> object:
    """Return a value as JSON has it; arrays are put aside, and their places stand for them."""
    if isinstance(value, np.ndarray):
        array = cast("NDArray[Any]", value)
        if array.dtype.kind not in "biuf":
            raise TypeError(f"an array of {array.dtype} cannot be kept")
        arrays.append(array)
        return len(arrays) - 1
    if isinstance(value, Enum):
        return value.value
    if value is None or isinstance(value, _PLAIN):
        return value
    if isinstance(value, tuple):
        return [_tree(one, arrays) for one in cast("tuple[object, ...]", value)]
    if isinstance(value, Mapping):
        return {key: _tree(one, arrays) for key, one in cast("Mapping[str, object]", value).items()}
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: _tree(getattr(value, field.name), arrays) for field in fields(value)}
    raise TypeError(f"{type(value).__name__} cannot be kept")


def _value(tree: Any, kind: Any, array_at: Callable[[int], NDArray[Any]]) -> object:  # noqa: ANN401 - annotations and JSON are of any type
    """Return what JSON stands for, as an annotation says."""
    origin, arguments = get_origin(kind), get_args(kind)
    if origin in {Union, types.UnionType}:
        (other,) = (one for one in arguments if one is not types.NoneType)
        found = None if tree is None else _value(tree, other, array_at)
    elif origin is np.ndarray:
        found = array_at(tree)
    elif origin is tuple:
        kinds = [arguments[0]] * len(tree) if arguments[-1] is Ellipsis else arguments
        found = tuple(_value(one, each, array_at) for one, each in zip(tree, kinds, strict=True))
    elif origin is not None and issubclass(origin, Mapping):
        found = {key: _value(one, arguments[1], array_at) for key, one in tree.items()}
    elif is_dataclass(kind):
        hints = get_type_hints(kind)
        parts = {field.name: _value(tree[field.name], hints[field.name], array_at) for field in fields(kind)}
        found = cast("Callable[..., object]", kind)(**parts)
    elif issubclass(kind, Enum):
        found = kind(tree)
    else:
        found = _plain(tree, kind)
    return found


def _plain(tree: object, kind: type) -> object:
    if not isinstance(tree, (int, float) if kind is float else kind):
        raise TypeError(f"{tree!r} is no {kind}")
    return tree
