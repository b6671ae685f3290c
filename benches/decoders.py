"""How long cantools and opendbc's CANParser take to decode a candump log: prints "NAME FRAMES SECONDS".

decoders.py DBC LOG
    cantools decodes the frames of the DBC's messages; opendbc those of the same identifiers, by the database of its own
    that it has for a Toyota of these years. Only decoding is timed.
"""

import sys
import time

import cantools
from opendbc.can import CANParser

DATABASE = "toyota_nodsu_pt_generated"


def frames(path, identifiers):
    with open(path) as log:
        for line in log:
            stamp, _, frame = line.split()
            identifier, data = frame.split("#")
            if int(identifier, 16) in identifiers:
                yield int(float(stamp[1:-1]) * 1e9), int(identifier, 16), bytes.fromhex(data)


def main():
    database = cantools.database.load_file(sys.argv[1])
    identifiers = {message.frame_id for message in database.messages}
    log = list(frames(sys.argv[2], identifiers))

    begun = time.perf_counter()
    for _, identifier, data in log:
        database.decode_message(identifier, data, decode_choices=False)
    print("cantools", len(log), time.perf_counter() - begun)

    parser = CANParser(DATABASE, [(identifier, 80) for identifier in sorted(identifiers)], 0)
    packets = [(nanos, [(identifier, data, 0)]) for nanos, identifier, data in log]
    begun = time.perf_counter()
    for packet in packets:
        parser.update([packet])
    print("opendbc", len(log), time.perf_counter() - begun)


main()
