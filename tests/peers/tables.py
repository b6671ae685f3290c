"""Are these Parquet and MCAP tables what polars makes of the CSV tables of the same names? tables.py TABLE.parquet TABLE.mcap ...

Fails with what differs, else prints each table's rows and columns, and a line of its metadata.
"""

import json
import sys
from pathlib import Path

import polars
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def compare_mcap(path):
    csv = polars.read_csv(path.with_suffix(".csv"), infer_schema_length=None)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        statistics = reader.get_summary().statistics
        rows, units = 0, 0
        # In the order of the file, which is that of the index.
        for (schema, channel, message, row), expected in zip(reader.iter_decoded_messages(), csv.iter_rows(named=True)):
            assert (schema.name, channel.topic) == (f"gripd.{path.stem}", f"/gripd/{path.stem}"), channel
            assert message.log_time == round(expected["t"] * 1e6) * 1000, message.log_time
            ours = {field.name: getattr(row, field.name) for field in row.DESCRIPTOR.fields}
            ours = {name: None if value != value else value for name, value in ours.items()}
            assert ours == expected, (ours, expected)
            rows, units = rows + 1, len(channel.metadata)
        assert rows == csv.height == statistics.message_count, (rows, csv.height, statistics)
        # From within, by the index.
        half = int(csv["t"][csv.height // 2] * 1e9)
        later = sum(1 for _ in reader.iter_messages(starting_at=half))
        assert later == (csv["t"] * 1e9 >= half).sum(), later
    print(path.stem, rows, units)


def compare(path):
    if path.suffix == ".mcap":
        return compare_mcap(path)
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
