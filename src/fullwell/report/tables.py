"""The rows of the results as CSV and as Parquet: the same values as in the document."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import pyarrow as pa
import pyarrow.parquet as pq

from fullwell.figures.results import Row
from fullwell.report.document import ROW_KEYS, Plain, row_record

_TEXT: Final = frozenset({"quantity", "channel", "method", "unit", "region", "source"})


def rows_csv(rows: Sequence[Row]) -> str:
    """Return the rows as CSV with a header; what is unknown is empty, flags are joined by ``;``."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(ROW_KEYS)
    for row in rows:
        table.writerow([_cell(value) for value in row_record(row).values()])
    return text.getvalue()


def _cell(value: Plain) -> str:
    if value is None:
        return ""
    if isinstance(value, list):
        return ";".join(str(item) for item in value)
    return str(value)


def write_parquet(rows: Sequence[Row], path: Path) -> None:
    """Write the rows as a typed table: text, 64-bit floats, ``n`` an integer, flags a list of text."""
    special = {"flags": pa.list_(pa.string()), "n": pa.int64()}
    text, number = pa.string(), pa.float64()
    schema = pa.schema([(key, special.get(key, text if key in _TEXT else number)) for key in ROW_KEYS])
    pq.write_table(pa.Table.from_pylist([row_record(row) for row in rows], schema=schema), path)
