"""A fleet on several processes, from an object store and back: nothing lost, nothing twice, whatever dies on the way.

python_fleet.py PROJECT FOLDER [DRIVES [SECONDS [TEST…]]]

PROJECT is the repository; files go to FOLDER. DRIVES of SECONDS each are simulated. Prints what the guide says.
"""

import json
import logging
import os
import signal
import subprocess
import sys
import threading
import time
import unittest
from pathlib import Path

import distributed
import fsspec
import gripd
import polars
import pyarrow as pa
from gripd import fleet
from moto.server import ThreadedMotoServer

PROJECT, FOLDER = Path(sys.argv[1]), Path(sys.argv[2])
DRIVES = int(sys.argv[3]) if len(sys.argv) > 3 else 24
CARS = 3
SECONDS = float(sys.argv[4]) if len(sys.argv) > 4 else 30.0
LEAST_SECONDS_TO_KILL_IN = 0.3


def scenario(drive):
    text = (PROJECT / "config/scenarios/demo.toml").read_text()
    path = FOLDER / "scenario.toml"
    path.write_text(text.replace("duration_s = 120.0", f"duration_s = {SECONDS}"))
    out = FOLDER / f"drive_{drive}.log"
    gripd.simulate(path, out, seed=drive)
    return out


def parquet(fs, folder):
    fs.invalidate_cache()
    return sorted(file for file in fs.find(folder) if file.endswith(".parquet"))


class Fleet(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
        cls.server.start()
        logging.getLogger("werkzeug").setLevel(logging.ERROR)
        host, port = cls.server.get_host_and_port()
        # Workers are told by their environment where the store is.
        os.environ.update(
            AWS_ENDPOINT_URL=f"http://{host}:{port}",
            AWS_ACCESS_KEY_ID="anyone",
            AWS_SECRET_ACCESS_KEY="anything",
            AWS_DEFAULT_REGION="us-east-1",
        )
        cls.fs = fsspec.filesystem("s3")
        cls.fs.mkdir("fleet")
        for name in ("config/demo.toml", "dbc/demo.dbc", "dbc/gripd.dbc"):
            cls.fs.put_file(str(PROJECT / name), f"fleet/car/{name}")
        cls.logs = {}
        for drive in range(DRIVES):
            name = f"car_{drive % CARS}/drive_{drive:03}.log"
            cls.logs[name] = scenario(drive)
            cls.fs.put_file(str(cls.logs[name]), f"fleet/drives/{name}")
        cls.config, cls.drives = "s3://fleet/car/config/demo.toml", "s3://fleet/drives"
        # Two that are bad: one that is cut off within its packing, and one that is none.
        packed = subprocess.run(["gzip", "-c", cls.logs["car_0/drive_000.log"]], capture_output=True, check=True)
        cls.fs.pipe_file("fleet/drives/car_0/cut.log.gz", packed.stdout[: len(packed.stdout) // 2])
        cls.fs.pipe_file("fleet/drives/car_0/notes.txt", b"the left front tire was changed in May\n")

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()

    def test_a_worker_that_is_killed_loses_nothing(self):
        out = "s3://fleet/killed"
        victims = []

        def kill(client):
            time.sleep(LEAST_SECONDS_TO_KILL_IN)
            pids = client.run(os.getpid)
            busy = [worker for worker, tasks in client.processing().items() if tasks]
            victims.append(pids[busy[0]])
            os.kill(victims[0], signal.SIGKILL)

        begin = time.monotonic()
        with (
            distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
            distributed.Client(cluster) as client,
        ):
            seen = []
            killer = threading.Thread(target=kill, args=[client])

            def progress(done, bad, count):
                seen.append((done, bad, count))
                if done == DRIVES // 4:
                    killer.start()

            report = fleet.replay(self.config, self.drives, out, client=client, progress=progress)
            killer.join()
        print(f"two workers, one killed | {DRIVES} | {time.monotonic() - begin:.1f} s")
        self.assertEqual(len(victims), 1)
        self.assertEqual(seen[-1], (DRIVES + 2, 2, DRIVES + 2))
        self.check_whole(report, out)

    def check_whole(self, report, out):
        """All is there once, as one process would have it, and what is bad is told."""
        names = {outcome.name for outcome in report.done}
        self.assertEqual(names, set(self.logs) | {"car_0/cut.log.gz"})
        self.assertEqual([outcome.name for outcome in report.bad], ["car_0/cut.log.gz", "car_0/notes.txt"])
        cut, none = report.bad
        self.assertTrue(cut.has_result and not none.has_result, (cut, none))
        self.assertTrue(none.problem.startswith(f"{self.drives}/car_0/notes.txt"), none.problem)
        self.assertEqual(len(parquet(self.fs, out)), DRIVES + 1)
        whole = polars.scan_parquet(f"{out}/estimates/**/*.parquet", hive_partitioning=True)
        rows = dict(whole.group_by("recording").len().collect().iter_rows())
        for name in list(self.logs)[::5]:
            alone = gripd.replay(PROJECT / "config/demo.toml", self.logs[name]).estimates
            self.assertEqual(rows[name], alone.num_rows, name)
            part = whole.filter(polars.col("recording") == name).drop("recording").collect()
            self.assertTrue(part.equals(polars.from_arrow(alone)), name)

    def test_what_was_interrupted_goes_on(self):
        out = "s3://fleet/interrupted"

        class Enough(Exception):
            pass

        def progress(done, bad, count):
            if done == DRIVES // 2:
                raise Enough

        with self.assertRaises(Enough):
            fleet.replay(self.config, self.drives, out, workers=2, progress=progress)
        report = fleet.replay(self.config, self.drives, out, workers=2)
        self.assertTrue(0 < report.new <= DRIVES + 2 - DRIVES // 2, report.new)
        self.check_whole(report, out)
        again = fleet.replay(self.config, self.drives, out)
        self.assertEqual((again.new, again.done), (0, report.done))
        # Another recording under a name that was there.
        other, name = list(self.logs.values())[1], "car_0/drive_000.log"
        self.fs.put_file(str(other), f"fleet/drives/{name}")
        changed = fleet.replay(self.config, self.drives, out, workers=1)
        self.assertEqual((changed.new, len(changed.done)), (1, DRIVES + 1))
        # And none at all: its results go, too.
        self.fs.pipe_file(f"fleet/drives/{name}", b"no recording\n")
        spoiled = fleet.replay(self.config, self.drives, out, workers=1)
        self.fs.put_file(str(self.logs[name]), f"fleet/drives/{name}")
        self.assertEqual((spoiled.new, len(spoiled.done), len(parquet(self.fs, out))), (1, DRIVES, DRIVES))

    def test_two_processes_beside_one(self):
        logs = list(self.logs.values())
        begin = time.monotonic()
        for number, log in enumerate(logs):
            pa.parquet.write_table(gripd.replay(PROJECT / "config/demo.toml", log).estimates, FOLDER / f"{number}.parquet")
        one = time.monotonic() - begin
        print(f"one process, no engine | {DRIVES} | {one:.1f} s")
        for workers in (1, 2):
            out = FOLDER / f"by_{workers}"
            report = fleet.replay(PROJECT / "config/demo.toml", logs, out, workers=workers)
            self.assertEqual((len(report.done), report.bad), (DRIVES, []))
            print(f"{workers} workers | {DRIVES} | {report.seconds:.1f} s, start and end of the cluster included")
        self.assertEqual(len(list(out.rglob("*.part"))), 0)

    def test_a_wrong_configuration_ends_it(self):
        wrong = FOLDER / "wrong/demo.toml"
        wrong.parent.mkdir()
        wrong.write_text((PROJECT / "config/demo.toml").read_text().replace("[vehicle]", "[vehicel]"))
        with self.assertRaisesRegex(gripd.UsageError, "vehicel"):
            fleet.replay(wrong, self.drives, FOLDER / "wrong_out", workers=1)

    def test_the_command_says_what_is_bad(self):
        command = [sys.executable, "-m", "gripd.fleet", "replay", self.config, self.drives, FOLDER / "by_command"]
        run = subprocess.run([*map(str, command), "--workers", "2"], capture_output=True, text=True)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("car_0/notes.txt: ", run.stderr)
        self.assertTrue(run.stdout.startswith(f"{DRIVES + 1} done, {DRIVES + 2} of this call, 2 bad, "), run.stdout)

    def test_causes_since_when(self):
        cars = {"alone": [None], "healthy": [None] * 4, "worn": [None, None, -0.02, -0.02]}
        folder = FOLDER / "causes"
        scenario(0)
        for car, drives in cars.items():
            for number, relative in enumerate(drives):
                text = (FOLDER / "scenario.toml").read_text()
                if relative:
                    text += f'\n[[effect]]\nkind = "tire_radius"\nrelative_difference_rl = {relative}\n'
                (folder / "drives" / car).mkdir(parents=True, exist_ok=True)
                (FOLDER / "worn.toml").write_text(text)
                gripd.simulate(FOLDER / "worn.toml", folder / "drives" / car / f"{number}.log", seed=number + 5)
        config = PROJECT / "config/demo.toml"
        report = fleet.explain(config, folder / "drives", folder / "out", history=True)
        self.assertEqual([outcome.problem for outcome in report.done], [None, None])
        self.assertEqual([(outcome.name, outcome.problem) for outcome in report.bad],
                         [("alone", "a car's only drive cannot be compared")])
        changes = polars.read_parquet(folder / "out/changes/**/*.parquet").sort("car").to_dicts()
        print(json.dumps(changes, indent=1))
        self.assertEqual({change["car"] for change in changes}, {"worn"})
        wheel = next(change for change in changes if change["effect"] == "tire_radius")
        self.assertTrue(wheel["since"].endswith("2.log") and wheel["drives"] == 4, wheel)
        self.assertAlmostEqual(wheel["value"], -0.02, delta=0.002)
        # One drive alone.
        report = fleet.explain(config, [folder / "drives/worn/3.log"], folder / "alone")
        findings = polars.read_parquet(folder / "alone/findings/**/*.parquet")
        print(findings)
        self.assertEqual((len(report.done), set(findings["recording"])), (1, {"3.log"}))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[5:]], verbosity=2)
