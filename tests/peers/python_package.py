"""The Python package beside the commands: the same numbers, the same words, Arrow for everybody, Ctrl-C.

python_package.py GRIPD PROJECT FOLDER

GRIPD is the program, PROJECT the repository; files go to FOLDER.
"""

import bisect
import csv
import gzip
import importlib.util
import inspect
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
import unittest
from pathlib import Path

import gripd
import pandas
import polars
import pyarrow as pa
import pyarrow.parquet as pq

PROGRAM, PROJECT, FOLDER = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
CONFIG = PROJECT / "config/demo.toml"
SECONDS = 45


def command(*arguments):
    """The command as a user runs it: its exit code, and what it says of why."""
    run = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, cwd=FOLDER)
    said = re.search(r"^gripd: (.*)\Z", run.stderr.strip(), flags=re.MULTILINE | re.DOTALL)
    return run.returncode, said[1] if said else ""


def scenario(seconds):
    text = (PROJECT / "config/scenarios/demo.toml").read_text()
    path = FOLDER / f"{seconds}.toml"
    path.write_text(text.replace("duration_s = 120.0", f"duration_s = {seconds}.0"))
    return path


def same_bits(one, other):
    """Equal tables, not-a-number and signs of zero included."""
    if one.column_names != other.column_names or one.num_rows != other.num_rows:
        return False
    # Of what is written to the same format the bytes are compared.
    sinks = [pa.BufferOutputStream(), pa.BufferOutputStream()]
    for table, sink in zip((one, other), sinks):
        plain = table.combine_chunks().replace_schema_metadata(None)
        plain = plain.cast(pa.schema([field.with_metadata(None) for field in plain.schema]))
        pq.write_table(plain, sink, compression="none")
    first, second = (sink.getvalue() for sink in sinks)
    return first.equals(second)


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.log = FOLDER / "drive.log"
        cls.truth = gripd.simulate(scenario(SECONDS), cls.log, seed=7)
        cls.drive = gripd.replay(CONFIG, cls.log)

    def test_a_simulation_is_the_commands(self):
        log, truth = FOLDER / "command.log", FOLDER / "truth.csv"
        code, _ = command("simulate", scenario(SECONDS), "-o", log, "--truth", truth, "--seed", 7)
        self.assertEqual(code, 0)
        self.assertEqual(log.read_bytes(), self.log.read_bytes())
        with truth.open() as file:
            names, *rows = csv.reader(file)
        self.assertEqual(self.truth.column_names, names)
        columns = [[float(cell) if cell else None for cell in column] for column in zip(*rows)]
        self.assertEqual(len(rows), SECONDS * 100 + 1)
        for name, column in zip(names, columns):
            self.assertEqual(self.truth[name].to_pylist(), column, name)

    def test_a_replay_is_the_commands(self):
        estimates, samples, out, stats = (FOLDER / name for name in ("e.parquet", "s.parquet", "o.log", "s.json"))
        code, _ = command("replay", "-c", CONFIG, self.log, "-o", out, "--estimates", estimates,
                          "--samples", samples, "--stats", stats)
        self.assertEqual(code, 0)
        self.assertTrue(same_bits(self.drive.estimates, pq.read_table(estimates)))
        self.assertTrue(same_bits(self.drive.samples, pq.read_table(samples)))
        self.assertGreater(self.drive.estimates["mu_max_low"].null_count, 0)
        published = self.drive.published.to_pylist()
        lines = [f"({row['t']:.6f}) vcan0 {row['id']:03X}#{row['data'].hex().upper()}" for row in published]
        self.assertEqual(lines, out.read_text().splitlines())
        of_command = json.loads(stats.read_text())
        for counts in (of_command, self.drive.stats):
            self.assertGreater(counts.pop("wall_s"), 0.0)
            self.assertGreater(counts.pop("frames_per_s"), 0.0)
        self.assertEqual(of_command, self.drive.stats)

    def test_columns_say_their_units(self):
        units = {field.name: field.metadata[b"unit"].decode() for field in self.drive.estimates.schema}
        self.assertEqual(units["speed"], "m/s")
        self.assertEqual(units["cornering_front"], "1/rad")

    def test_a_part_is_the_commands(self):
        samples = FOLDER / "part.parquet"
        code, _ = command("replay", "-c", CONFIG, self.log, "--from", 10, "--to", 20.5, "--samples", samples)
        self.assertEqual(code, 0)
        part = gripd.replay(CONFIG, self.log, start=10, end=20.5).samples
        self.assertTrue(1000 < part.num_rows < 1100 and same_bits(part, pq.read_table(samples)))

    def test_several_recordings_are_one_drive(self):
        twice = gripd.replay(CONFIG, [self.log, str(self.log)])
        self.assertEqual(twice.stats["frames_in"], 2 * self.drive.stats["frames_in"])

    def test_streams_are_read_by_everybody(self):
        estimates = self.drive.estimates
        batches = list(gripd.stream(CONFIG, self.log, rows=1000))
        self.assertEqual({len(batch) for batch in batches[:-1]}, {1000})
        self.assertTrue(same_bits(pa.Table.from_batches(batches), estimates))
        self.assertTrue(same_bits(pa.table(gripd.stream(CONFIG, self.log)), estimates))
        frame = polars.DataFrame(gripd.stream(CONFIG, self.log, "samples"))
        self.assertEqual(frame.shape, self.drive.samples.shape)
        self.assertTrue(frame.equals(polars.from_arrow(self.drive.samples)))
        frame = pandas.DataFrame.from_arrow(gripd.stream(CONFIG, self.log, "published"))
        self.assertEqual(frame["data"].tolist(), self.drive.published["data"].to_pylist())
        stream = gripd.stream(CONFIG, self.log)
        pa.schema(stream)
        pa.table(stream)
        with self.assertRaisesRegex(gripd.UsageError, "has been read"):
            pa.table(stream)

    def test_what_is_published_is_decoded(self):
        out = FOLDER / "published.log"
        with out.open("w") as file:
            for row in self.drive.published.to_pylist():
                file.write(f"({row['t']:.6f}) vcan0 {row['id']:03X}#{row['data'].hex().upper()}\n")
        decoded = gripd.decode(PROJECT / "dbc/gripd.dbc", out)
        self.assertEqual(set(decoded), set(self.drive.published["message"].to_pylist()))
        only = gripd.decode(PROJECT / "dbc/gripd.dbc", out, messages=["GRIP_MOTION"])
        self.assertEqual(list(only), ["GRIP_MOTION"])
        # With each frame the speed that was estimated shortly before; half a step is lost on the bus.
        times, speeds = (self.drive.estimates[name].to_pylist() for name in ("t", "speed"))
        compared = 0
        motion = only["GRIP_MOTION"]
        self.assertEqual(motion.schema.field("Speed").metadata[b"unit"], b"m/s")
        for t, speed in zip(motion["t"].to_pylist(), motion["Speed"].to_pylist()):
            place = bisect.bisect_right(times, t)
            near = [value for value in speeds[max(place - 20, 0) : place + 1] if value is not None]
            if near and speed <= 102.3:
                self.assertTrue(min(near) - 0.026 <= speed <= max(near) + 0.026, (t, speed, near))
                compared += 1
        self.assertGreater(compared, 100)

    def test_answers_are_the_commands(self):
        answers = FOLDER / "identified.json", FOLDER / "explained.json"
        other = FOLDER / "held_out.log"
        gripd.simulate(scenario(30), other, seed=8)
        # Parts and few numbers, for a search takes as long as what it looks at.
        names = ["lateral_stiffness_front", "lateral_stiffness_rear"]
        code, _ = command("identify", "-c", CONFIG, self.log, "--starts", 1, "--to", 25, "--holdout", other,
                          "--parameters", ",".join(names), "--json", answers[0])
        self.assertEqual(code, 0)
        identified = gripd.identify(CONFIG, self.log, starts=1, end=25, holdout=other, parameters=names)
        self.assertEqual(identified, json.loads(answers[0].read_text()))
        self.assertTrue(identified["parameters"])
        self.assertIn("yaw_rate", identified["fit"]["holdout"]["after"])
        code, _ = command("explain", "-c", CONFIG, self.log, "--to", 25, "--json", answers[1])
        self.assertEqual(code, 0)
        explained = gripd.explain(CONFIG, [self.log], end=25)
        self.assertEqual(explained, json.loads(answers[1].read_text()))
        self.assertIn(explained["verdict"], ["missing_physics", "adequate", "unknown_physics", "insufficient_excitation"])

    def test_notebooks_come_to_their_ends(self):
        missing = [name for name in ("nbclient", "ipykernel", "matplotlib") if importlib.util.find_spec(name) is None]
        if missing:
            self.skipTest(f"no {' and '.join(missing)}")
        import nbclient
        import nbformat

        os.environ["PATH"] = os.pathsep.join([str(Path(PROGRAM).parent), os.environ["PATH"]])
        said = {}
        for path in sorted((PROJECT / "src/python/notebooks").glob("*.ipynb")):
            notebook = nbformat.read(path, as_version=4)
            cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
            self.assertFalse([cell.outputs for cell in cells if cell.outputs or cell.execution_count], path)
            begun = time.monotonic()
            nbclient.NotebookClient(notebook, resources={"metadata": {"path": str(path.parent)}}).execute()
            nbformat.write(notebook, FOLDER / path.name)
            print(f"{path.name}: {time.monotonic() - begun:.0f} s", file=sys.stderr)
            outputs = [output for cell in cells for output in cell.outputs]
            said[path.stem] = "".join(output.text for output in outputs if output.output_type == "stream")
            drawn = [output for output in outputs if "image/png" in output.get("data", {})]
            self.assertEqual(len(drawn), sum("plt.show()" in cell.source for cell in cells), path)
        mapped, explained = said["map_a_car"], said["explain_a_drive"]
        self.assertRegex(mapped, r"yaw_rate +sure +INERTIAL\.YawRate")
        self.assertLess(float(re.search(r"speed is off by ([\d.]+) m/s", mapped)[1]), 0.1)
        self.assertGreaterEqual(int(re.search(r"in (\d+) % of the valid time", mapped)[1]), 90)
        self.assertIn("missing_physics", explained)
        self.assertIn("named: crosswind", explained)

    def test_errors_say_what_the_commands_say(self):
        wrong = FOLDER / "wrong.toml"
        wrong.write_text(CONFIG.read_text().replace("mass_kg", "mas_kg"))
        none = FOLDER / "none.log"
        other = FOLDER / "other.log"
        other.write_text("(1.000000) can0 123#00\n")
        for error, code, function, arguments in [
            (gripd.UsageError, 2, lambda: gripd.replay(wrong, self.log), ["replay", "-c", wrong, self.log]),
            (gripd.WorkError, 1, lambda: gripd.replay(CONFIG, none), ["replay", "-c", CONFIG, none]),
            (gripd.WorkError, 1, lambda: gripd.replay(CONFIG, other), ["replay", "-c", CONFIG, other]),
            (gripd.UsageError, 2, lambda: gripd.replay(CONFIG, self.log, start=9, end=3),
             ["replay", "-c", CONFIG, self.log, "--from", 9, "--to", 3]),
            (gripd.WorkError, 1, lambda: gripd.explain(CONFIG, other), ["explain", "-c", CONFIG, other]),
            (gripd.UsageError, 2, lambda: gripd.explain(CONFIG, self.log, history=True),
             ["explain", "-c", CONFIG, self.log, "--history"]),
            (gripd.UsageError, 2, lambda: gripd.identify(CONFIG, self.log, parameters=["nothing"]),
             ["identify", "-c", CONFIG, self.log, "--parameters", "nothing"]),
            (gripd.UsageError, 2, lambda: gripd.simulate(none, FOLDER / "x.log"),
             ["simulate", none, "-o", FOLDER / "x.log"]),
        ]:
            with self.subTest(arguments=arguments):
                status, words = command(*arguments)
                self.assertEqual(status, code, words)
                with self.assertRaises(error) as raised:
                    function()
                self.assertEqual(str(raised.exception), words)
                self.assertIsInstance(raised.exception, gripd.Error)
        with self.assertRaisesRegex(gripd.UsageError, "cannot be used with"):
            gripd.explain(CONFIG, self.log, history=True, holdout=self.log)
        with self.assertRaisesRegex(gripd.UsageError, "no table"):
            gripd.stream(CONFIG, self.log, "estimate")
        with self.assertRaisesRegex(gripd.UsageError, "no message"):
            gripd.decode(PROJECT / "dbc/gripd.dbc", self.log, messages=["GRIP"])
        self.assertRaises(TypeError, gripd.replay, CONFIG)

    def test_what_is_broken_is_worth_its_results(self):
        packed = FOLDER / "cut.log.gz"
        whole = gzip.compress(self.log.read_bytes())
        packed.write_bytes(whole[: len(whole) // 2])
        code, words = command("replay", "-c", CONFIG, packed)
        self.assertEqual(code, 1)
        with self.assertRaises(gripd.BrokenRecording) as raised:
            gripd.replay(CONFIG, packed)
        self.assertEqual(str(raised.exception), words)
        got = raised.exception.result.estimates.num_rows
        self.assertTrue(1000 < got < self.drive.estimates.num_rows)
        rows = 0
        with self.assertRaises(Exception) as raised:
            for batch in gripd.stream(CONFIG, packed, rows=500):
                rows += len(batch)
        self.assertEqual(rows, got)
        self.assertIn(words, str(raised.exception))

    def test_warnings_are_logged(self):
        damaged = FOLDER / "damaged.log"
        damaged.write_text("nonsense\n" + self.log.read_text())
        with self.assertLogs("gripd", "WARNING") as logged:
            gripd.replay(CONFIG, damaged)
        self.assertTrue(any("damaged.log:1:" in line for line in logged.output), logged.output)

    def test_others_run_beside_it(self):
        done, ticks = threading.Event(), 0

        def work():
            gripd.replay(CONFIG, [self.log] * 8)
            done.set()

        thread = threading.Thread(target=work)
        begun = time.monotonic()
        thread.start()
        longest, last = 0.0, begun
        while not done.is_set():
            time.sleep(0.001)
            now = time.monotonic()
            longest, last, ticks = max(longest, now - last), now, ticks + 1
        thread.join()
        # With the lock held there would be a tick or two in all.
        self.assertGreater(ticks, 20)
        self.assertLess(longest, 0.5 * (last - begun))

    def test_ctrl_c_ends_it(self):
        log = FOLDER / "long.log"
        gripd.simulate(scenario(400), log)
        for call in (f"gripd.explain({str(CONFIG)!r}, {str(log)!r})",
                     f"gripd.replay({str(CONFIG)!r}, [{str(log)!r}] * 200)",
                     f"gripd.simulate({str(scenario(100000))!r}, {str(FOLDER / 'never.log')!r})"):
            with self.subTest(call=call):
                code = f"import gripd, os; print('begun', flush=True)\ntry:\n {call}\nexcept KeyboardInterrupt:\n print('ended', flush=True)\n os._exit(7)"
                run = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
                self.assertEqual(run.stdout.readline(), "begun\n")
                time.sleep(1.0)
                begun = time.monotonic()
                run.send_signal(signal.SIGINT)
                self.assertEqual(run.stdout.readline(), "ended\n")
                self.assertLess(time.monotonic() - begun, 2.0)
                self.assertEqual(run.wait(), 7)
        self.assertFalse((FOLDER / "never.log").exists())

    def test_everything_is_documented_and_typed(self):
        self.assertTrue((Path(gripd.__file__).parent / "py.typed").exists())
        self.assertTrue((Path(gripd.__file__).parent / "_gripd.pyi").exists())
        stubs = (Path(gripd.__file__).parent / "_gripd.pyi").read_text()
        for name in gripd.__all__:
            self.assertTrue(name == "__version__" or inspect.getdoc(getattr(gripd, name)), name)
        for name, thing in vars(gripd._gripd).items():
            if callable(thing):
                self.assertRegex(stubs, rf"(def|class) {name}\b")
            if inspect.isbuiltin(thing):
                told = stubs.split(f"def {name}(")[1].split(") ->")[0]
                told = [word.split(":")[0].strip() for word in told.split(",") if ":" in word]
                self.assertEqual(list(inspect.signature(thing).parameters), told, name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
