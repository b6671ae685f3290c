"""Are these Parquet tables what polars makes of the CSV tables of the same names? tables.py TABLE.parquet ...

Fails with what differs, else prints each table's rows and columns, and a line of its metadata.
"""

import json
import sys
from pathlib import Path

import polars


def compare(path):
    parquet = polars.read_parquet(path)
    # All rows: the first thousand of a column may be empty.
    csv = polars.read_csv(path.with_suffix(".csv"), infer_schema_length=None)
    assert parquet.columns == csv.columns, (parquet.columns, csv.columns)
    assert parquet.height == csv.height, (parquet.height, csv.height)
    for name in csv.columns:
        ours, theirs = parquet[name], csv[name]
        if ours.dtype != polars.String:
            ours, theirs = ours.cast(polars.Float64), theirs.cast(polars.Float64)
        assert ours.equals(theirs, null_equal=True), name
    about = polars.read_parquet_metadata(path)
    units = json.loads(about["gripd.units"])
    assert set(units) == set(csv.columns), units
    kinds = sorted({str(kind) for kind in parquet.schema.values()})
    print(about["gripd.table"], parquet.height, parquet.width, about["gripd.version"], units["t"], *kinds)


for argument in sys.argv[1:]:
    compare(Path(argument))
