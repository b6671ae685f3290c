"""The mapping to VSS as the KUKSA CAN provider applies it (its mapping/README.md), with its own libraries.

vss.py PROJECT

cantools decodes, py_expression_eval computes. Prints how many observations were compared.
"""

import json
import re
import sys
from pathlib import Path

import cantools
from py_expression_eval import Parser

PROJECT = Path(sys.argv[1])
SIGNALS = {"MostProbable": "MuMax", "LowerBound": "MuMaxLow", "UpperBound": "MuMaxHigh"}
ROOT = "Vehicle.ADAS.ESC.RoadFriction"


def leaves(node, path):
    for name, child in node.items():
        if child["type"] == "branch":
            yield from leaves(child["children"], f"{path}{name}.")
        else:
            yield f"{path}{name}", child


def updates(mapping, message, payload):
    """What the provider sends to the databroker for a frame."""
    decoded = message.decode(payload)
    told = {}
    for path, leaf in mapping.items():
        rule = leaf["dbc2vss"]
        value = decoded[rule["signal"]]
        signal = message.get_signal_by_name(rule["signal"])
        if isinstance(value, (int, float)) and not signal.minimum <= value <= signal.maximum:
            continue
        if any(decoded[other["signal"]] != other["value"] for other in rule.get("multiplexer", [])):
            continue
        try:
            told[path] = Parser().parse(rule["transform"]["math"]).evaluate({"x": value})
        except TypeError:
            # "not_available" is a word, and no number: there is no update.
            continue
    return told


def main():
    mapping = dict(leaves(json.loads((PROJECT / "config/vss/vss_dbc.json").read_text()), ""))
    assert set(mapping) == {f"{ROOT}.{name}" for name in SIGNALS}, mapping.keys()
    published, message = (
        cantools.database.load_file(PROJECT / path).get_message_by_name("GRIP_FRICTION")
        for path in ("dbc/gripd.dbc", "config/vss/friction.dbc")
    )

    # The overlay says the same as the tree.
    overlay = (PROJECT / "config/vss/gripd.vspec").read_text()
    blocks = re.split(r"^(?=Vehicle\.)", overlay, flags=re.MULTILINE)[1:]
    assert len(blocks) == len(mapping)
    for block in blocks:
        leaf = mapping[block.split(":")[0]]
        rule = leaf["dbc2vss"]
        says = dict(re.findall(r'^ +(?:- )?(\w+): "?([^"\n]+)"?$', block, flags=re.MULTILINE))
        gated = "multiplexer" in rule
        assert (says["type"], says["datatype"], says["math"], int(says["interval_ms"])) == (
            leaf["type"], leaf["datatype"], rule["transform"]["math"], rule["interval_ms"]), block
        assert re.search(r"signal: (\w+)", block)[1] == rule["signal"]
        assert ("signal: MuValid" in block) == gated and (not gated or says["value"] == "1"), block

    compared = 0
    for raw in range(1024):
        for valid in (0, 1):
            values = {signal: 0 for signal in published.signal_tree}
            values |= {signal: raw for signal in SIGNALS.values()} | {"MuValid": valid}
            payload = published.encode(values, scaling=False, strict=False)
            told = updates(mapping, message, payload)
            for name, signal in SIGNALS.items():
                # 1023 says "not available"; a bound from below stands without the flag.
                is_told = raw != 1023 and (valid == 1 or name == "LowerBound")
                wanted = min(0.2 * raw, 100.0) if is_told else None
                got = told.get(f"{ROOT}.{name}")
                assert (got is None) == (wanted is None), (name, raw, valid, got)
                assert got is None or abs(got - wanted) < 1e-9 and 0 <= got <= 100, (name, raw, got)
                compared += 1
    print(compared)


main()
