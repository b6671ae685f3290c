"""What cantools makes of a DBC file: the reference for tests/formats/{dbc,publish}_cantools.rs.

decode OUT DBC [--payloads N] [--log LOG]
    One JSON object per message and line. Numbers are the sixteen hexadecimal digits of the double, so
    that nothing is lost on the way; null stands for a signal that is not in the frame.
e2e    Reads lines "ID PAYLOAD" (hexadecimal), writes "True" or "False" for each.
strict DBC
    Loads the file with all of cantools' checks on, then decodes lines "ID PAYLOAD" to JSON objects.
"""

import argparse
import gzip
import json
import random
import re
import struct
import sys

import cantools
from cantools.database.utils import create_encode_decode_formats, decode_data, encode_data

EXTENDED = 1 << 31


def hexadecimal(number):
    return struct.pack(">d", float(number)).hex()


def load(path):
    """Loads a file leniently, after marking identifiers that are wider than their kind as extended."""
    with open(path, "rb") as file:
        raw = file.read()
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("cp1252")
    repaired = []

    def repair(match):
        number = int(match[2])
        if 0x7FF < number < EXTENDED and match[3] != "VECTOR__INDEPENDENT_SIG_MSG":
            repaired.append(match[3])
            number |= EXTENDED
        return f"{match[1]}{number} {match[3]}"

    text = re.sub(r"^(BO_ +)(\d+) +(\w+)", repair, text, flags=re.M)
    database = cantools.database.load_string(text, database_format="dbc", strict=False)
    return database, repaired


def bit_positions(signal):
    """Places of the bits, least significant first, as indices into the payload read byte by byte."""
    if signal.byte_order == "little_endian":
        return [8 * (n // 8) + 7 - n % 8 for n in range(signal.start, signal.start + signal.length)]
    first = 8 * (signal.start // 8) + 7 - signal.start % 8
    return list(range(first, first + signal.length))[::-1]


def put(payload, signal, value):
    for index, place in enumerate(bit_positions(signal)):
        mask = 0x80 >> place % 8
        payload[place // 8] &= ~mask & 0xFF
        if value >> index & 1:
            payload[place // 8] |= mask


class Reference:
    """One message, by cantools' own conversion; signal by signal where signals overlap, since there
    cantools' whole-message codec shifts what follows, or where it leaves some out."""

    def __init__(self, message):
        self.message = message
        length = message.length
        self.usable = [s for s in message.signals if max(bit_positions(s)) < 8 * length]
        self.unusable = [s.name for s in message.signals if s not in self.usable]
        self.formats = {s.name: create_encode_decode_formats([s], length) for s in self.usable}
        self.by_name = {s.name: s for s in self.usable}
        try:
            message.refresh(strict=True)
            self.whole = not self.unusable
        except cantools.database.errors.Error:
            message.refresh(strict=False)
            self.whole = False
        self.selectors = {}
        for signal in self.usable:
            if signal.multiplexer_signal in self.by_name:
                self.selectors.setdefault(signal.multiplexer_signal, set()).update(signal.multiplexer_ids or [])
                # vw_pq names a selector in SG_MUL_VAL_ but marks it "m" rather than "M": cantools loads
                # the signals below it but its whole-message codec never decodes them.
                if not self.by_name[signal.multiplexer_signal].is_multiplexer:
                    self.whole = False

    def single(self, payload, name, scaling=True):
        signal = self.by_name[name]
        length = self.message.length
        values = decode_data(payload, length, [signal], self.formats[name], False, scaling, False, True)
        return values[name]

    def active(self, payload, signal):
        while signal.multiplexer_signal is not None:
            if self.single(payload, signal.multiplexer_signal, False) not in signal.multiplexer_ids:
                return False
            signal = self.by_name[signal.multiplexer_signal]
        return True

    def decode(self, payload):
        if self.whole:
            try:
                return self.message.decode(payload, decode_choices=False)
            except cantools.database.errors.DecodeError:
                return None  # a selector has a value that nothing belongs to
        return {s.name: self.single(payload, s.name) for s in self.usable if self.active(payload, s)}

    def random_payload(self):
        payload = bytearray(random.randbytes(self.message.length))
        for name, ids in self.selectors.items():
            put(payload, self.by_name[name], random.choice(sorted(ids)))
        return bytes(payload)

    def nudged(self, name, value):
        """A number that is not exactly on a step, so that rounding is compared too."""
        signal = self.by_name[name]
        if signal.conversion.is_float or name in self.selectors:
            return float(value)
        return float(value + random.choice([0, 0, random.uniform(-0.49, 0.49)]) * signal.conversion.scale)

    def encode(self, values):
        """Bytes of all the values at once, or per signal where signals overlap; None if refused."""
        try:
            if self.whole:
                return self.message.encode(values, strict=False).hex()
            length = self.message.length
            return {
                name: encode_data({name: value}, [self.by_name[name]], self.formats[name], True)
                .to_bytes(length, "big")
                .hex()
                for name, value in values.items()
            }
        except Exception:  # of bitstruct: the number rounds to one beyond the bits
            return None


def recorded(path):
    """Payloads by identifier of a compressed candump recording."""
    payloads = {}
    with gzip.open(path, "rt") as lines:
        for line in lines:
            match = re.match(r"\(\S+\) \S+ ([0-9A-F]+)#([0-9A-F]*)", line)
            if match:
                key = (int(match[1], 16), len(match[1]) == 8)
                payloads.setdefault(key, []).append(bytes.fromhex(match[2]))
    return payloads


def decode(arguments):
    random.seed(arguments.seed)
    database, repaired = load(arguments.dbc)
    log = recorded(arguments.log) if arguments.log else None
    with open(arguments.out, "w", encoding="utf-8") as out:
        for message in database.messages:
            if message.name == "VECTOR__INDEPENDENT_SIG_MSG":
                continue
            reference = Reference(message)
            length = message.length
            if log is not None:
                payloads = log.get((message.frame_id, message.is_extended_frame), [])
                payloads = [payload for payload in payloads if len(payload) == length]
            else:
                payloads = [bytes(length), b"\xff" * length]
                payloads += [reference.random_payload() for _ in range(arguments.payloads)]
            rows = [(payload, reference.decode(payload)) for payload in payloads]
            rows = [(payload, values) for payload, values in rows if values is not None]
            encodings = []
            for _, values in rows if log is None else []:
                values = {name: reference.nudged(name, value) for name, value in values.items()}
                encoded = reference.encode(values)
                if encoded is not None:
                    encodings.append([{name: hexadecimal(v) for name, v in values.items()}, encoded])
            record = {
                "message": message.name,
                "id": message.frame_id,
                "extended": message.is_extended_frame,
                "length": length,
                "whole": reference.whole,
                "repaired": message.name in repaired,
                "unusable": reference.unusable,
                "payloads": [payload.hex() for payload, _ in rows],
                "signals": {
                    signal.name: [
                        hexadecimal(values[signal.name]) if signal.name in values else None for _, values in rows
                    ]
                    for signal in reference.usable
                },
                "encodings": encodings,
            }
            out.write(json.dumps(record) + "\n")


def frames():
    for line in sys.stdin:
        identifier, payload = line.split()
        yield int(identifier, 16), bytes.fromhex(payload)


def e2e(_):
    import e2e.p01 as profile

    for identifier, payload in frames():
        mode = profile.E2E_P01_DATAID_BOTH
        print(profile.e2e_p01_check(bytearray(payload), identifier & 0xFFFF, data_id_mode=mode))


def strict(arguments):
    database = cantools.database.load_file(arguments.dbc, strict=True)
    for identifier, payload in frames():
        message = database.get_message_by_frame_id(identifier)
        values = message.decode(payload, decode_choices=False)
        texts = message.decode(payload)
        print(json.dumps({
            "message": message.name,
            "cycle_time": message.cycle_time,
            "comments": [message.comment] + [signal.comment for signal in message.signals],
            "values": {name: hexadecimal(value) for name, value in values.items()},
            "texts": {name: str(value) for name, value in texts.items()},
        }))


def main():
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("decode")
    command.add_argument("out")
    command.add_argument("dbc")
    command.add_argument("--payloads", type=int, default=100)
    command.add_argument("--seed", type=int, default=1)
    command.add_argument("--log")
    command.set_defaults(run=decode)
    commands.add_parser("e2e").set_defaults(run=e2e)
    command = commands.add_parser("strict")
    command.add_argument("dbc")
    command.set_defaults(run=strict)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
