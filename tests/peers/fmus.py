"""fmus.py FOLDER: what FMPy makes of the FMUs in a folder, beside the truth that `gripd simulate` wrote.

FOLDER has car2.fmu, car3.fmu, correction2.fmu, correction3.fmu, and truth.csv, a row for each millisecond. Prints for each FMU how far both are apart at
most; fails where FMPy finds something wrong with one. Derivatives of inputs are left out: this FMPy sets them of nine inputs
only."""

import csv
import pathlib
import sys

import numpy as np
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

folder = pathlib.Path(sys.argv[1])
rows = list(csv.reader((folder / "truth.csv").open()))
truth = {name: np.array([float(row[i] or "nan") for row in rows[1:]]) for i, name in enumerate(rows[0])}
t = truth["t"]
columns = ["speed", "yaw_rate", "lateral_velocity", "lateral_acceleration", "longitudinal_acceleration", "sideslip", "x", "y"]
columns += ["heading", "wheel_speed_fl", "wheel_speed_rr", "slip_angle_front"]


def ramp(begin: float, end: float, value: float):
    return lambda t: value * np.clip((t - begin) / (end - begin), 0.0, 1.0)


# As the scenario of the test has them.
steering = [ramp(0.3, 0.8, 0.8), ramp(1.2, 1.8, -1.3)]
inputs = {
    "steering_wheel_angle": lambda t: sum(piece(t) for piece in steering),
    "drive_torque": ramp(0.2, 0.6, 500.0),
    "brake_torque": ramp(2.0, 2.4, 1500.0),
    "brake_pressure": np.zeros_like,
    "wanted_speed": np.zeros_like,
}


# What is set at each time: the inputs at the end of the step.
table = np.zeros(len(t), dtype=[("time", float)] + [(name, float) for name in inputs])
table["time"] = t
for name, value in inputs.items():
    table[name] = value(np.round(t + 1e-3, 6))

for version in "23":
    path = str(folder / f"correction{version}.fmu")
    problems = validate_fmu(path)
    assert not problems, f"{path}: {problems}"
    # Straight on there is nothing to correct.
    start = {"longitudinal_velocity": 20.0, "has_wheels": False}
    names = ["added_force_left", "added_yaw_moment", "error.yaw_rate"]
    result = simulate_fmu(path, stop_time=1.0, step_size=1e-2, start_values=start, output=names)
    assert all(abs(result[name][-1]) < 1e-9 for name in names), result[-1]
    path = str(folder / f"car{version}.fmu")
    problems = validate_fmu(path)
    assert not problems, f"{path}: {problems}"
    result = simulate_fmu(
        path,
        stop_time=float(t[-1]),
        step_size=1e-3,
        output_interval=1e-3,
        start_values={"initial_speed": 22.0, "inputs_are_of_the_end": True},
        input=table,
        output=columns,
    )
    assert len(result) == len(t), (len(result), len(t))
    apart = {name: float(np.max(np.abs(result[name] - truth[name]))) for name in columns}
    worst = max(apart, key=apart.get)
    print(f"{version},{worst},{apart[worst]:.3e}")
