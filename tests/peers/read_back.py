"""What python-can reads of recordings that gripd wrote. read_back.py FILE ...

Prints for each file its name, then a line for each frame: microseconds since 1970, channel, identifier, kind, length,
data.
"""

import os
import sys
import time

os.environ["TZ"] = "UTC"
time.tzset()

import can


def kind(message):
    if message.is_error_frame:
        return "error"
    if message.is_remote_frame:
        return "remote"
    if message.is_fd:
        return f"fd{int(message.bitrate_switch)}{int(message.error_state_indicator)}"
    return "data"


def main(paths):
    for path in paths:
        print(path)
        # Without this python-can leaves the date of an ASC file out.
        options = {"relative_timestamp": False} if path.endswith(".asc") else {}
        for message in can.LogReader(path, **options):
            # Of an error there is no more in any of the formats.
            known = not message.is_error_frame
            number = f"{message.arbitration_id:08X}" if message.is_extended_id else f"{message.arbitration_id:03X}"
            print(
                round(message.timestamp * 1e6),
                message.channel,
                number if known else "-",
                kind(message),
                message.dlc if message.is_remote_frame else len(message.data) if known else 0,
                bytes(message.data).hex() if known and message.data else "-",
            )


if __name__ == "__main__":
    main(sys.argv[1:])
