"""How long python-can takes to read a recording: prints "FRAMES SECONDS". formats.py FILE"""

import sys
import time

import can

begun = time.perf_counter()
count = sum(1 for _ in can.LogReader(sys.argv[1]))
print(count, time.perf_counter() - begun)
