"""MF4 files of gripd in asammdf. mdf.py PUBLISHED.mf4 DBC ESTIMATES.mf4 ESTIMATES.csv

Are the estimates' signals what the CSV twin says, to the last digit, with their units, and are those invalid that it
leaves empty? Does asammdf decode the published frames by the DBC, and to what the estimates say? Prints what it counted.
"""

import csv
import sys

import numpy
from asammdf import MDF


def signals(path, twin):
    with open(twin) as file:
        rows = list(csv.reader(file))
    names, columns = rows[0], list(zip(*rows[1:]))
    mdf = MDF(path)
    assert len(mdf.groups) == 1 and mdf.groups[0].channel_group.acq_name == "estimates", mdf.groups
    checked = missing = 0
    for name, column in zip(names[1:], columns[1:]):
        # With what is not valid, for the rows to be the same.
        signal = mdf.get(name, ignore_invalidation_bits=True)
        assert len(signal) == len(column), (name, len(signal), len(column))
        stamps = [f"{stamp + mdf.header.start_time.timestamp():.6f}" for stamp in signal.timestamps[:1000]]
        assert stamps == list(columns[0][:1000]), (name, stamps[:3], columns[0][:3])
        if signal.samples.dtype.kind == "S":
            assert [text.decode() for text in signal.samples] == list(column), name
        else:
            empty = numpy.array([text == "" for text in column])
            numbers = numpy.array([float(text or "nan") for text in column])
            assert numpy.array_equal(signal.samples.astype(float), numbers, equal_nan=True), name
            if empty.any():
                # Only what is there.
                assert len(mdf.get(name)) == numpy.count_nonzero(~empty), name
                missing += numpy.count_nonzero(empty)
        checked += 1
    units = [mdf.get(name).unit for name in ("speed", "cornering_front", "mu_max")]
    print("signals", checked, len(columns[0]), missing > 0, *units)
    return mdf


def published(path, dbc, estimates):
    decoded = MDF(path).extract_bus_logging({"CAN": [(dbc, 0)]})
    counts = [len(decoded.get(name, raw=True)) for name in ("MuUsed", "SlopeFL", "CorneringFront", "Speed")]
    speed, ours = decoded.get("Speed"), estimates.get("speed")
    shift = decoded.header.start_time.timestamp() - estimates.header.start_time.timestamp()
    # Half a microsecond: sums of seconds are not exact.
    places = numpy.searchsorted(ours.timestamps, speed.timestamps + shift + 5e-7, side="right") - 1
    # What is published is of the last sample or, while that is being made, of the one before.
    ages = [numpy.abs(ours.samples[numpy.maximum(places - age, 0)] - speed.samples) for age in range(3)]
    worst = numpy.min(ages, axis=0).max()
    print("published", *counts, speed.unit, worst < 0.026)


if __name__ == "__main__":
    published(sys.argv[1], sys.argv[2], signals(*sys.argv[3:]))
