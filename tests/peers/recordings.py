"""Writes a candump log in every other format, by python-can and, for MF4, asammdf.

recordings.py LOG FOLDER

The files are called after the writer and its options: python.asc, stored.blf, ... TRC gets neither remote requests nor
FD nor error frames, for python-can does not write them. Prints the names, one a line.
"""

import sys
from pathlib import Path

import can
from can.io.blf import BLFWriter


def main(log, folder):
    messages = list(can.CanutilsLogReader(log))
    folder = Path(folder)

    def write(writer, name, some=messages):
        for message in some:
            writer.on_message_received(message)
        writer.stop()
        print(name)

    def path(name):
        return str(folder / name)

    write(can.ASCWriter(path("python.asc")), "python.asc")
    write(BLFWriter(path("python.blf")), "python.blf")
    write(BLFWriter(path("stored.blf"), compression_level=0, max_container_size=1000), "stored.blf")
    write(can.CSVWriter(path("python.csv")), "python.csv")
    plain = [m for m in messages if not (m.is_fd or m.is_remote_frame or m.is_error_frame)]
    write(can.TRCWriter(path("python.trc")), "python.trc", plain)
    write(can.CanutilsLogWriter(path("python.log")), "python.log")
    for level, name in enumerate(["plain.mf4", "packed.mf4", "transposed.mf4"]):
        write(can.MF4Writer(path(name), compression_level=level), name)


if __name__ == "__main__":
    main(*sys.argv[1:])
