#!/usr/bin/env python3
"""Drives CommonRoad's single-track model with recorded steering and speed.

    single_track.py SAMPLES OUT [NAME=VALUE ...] [--log LOG --seed N]

SAMPLES is what `gripd replay --samples` writes: a column of time, the steering wheel angle, wheel speeds, in SI units.
OUT becomes a table that `gripd explain --simulation` reads. NAME=VALUE sets a number of the model: m, I_z, a, b, h_s,
stiffness (cornering stiffness over load and friction, 1/rad), friction, ratio (of the steering), radius (of the wheels, m),
delay (of the yaw rate, s), relaxation (length of both axles' tires, m). The last two are not CommonRoad's: they stand around
and beside its equations, so that a recording can have what the simulation has not.

With --log the same drive is written as a recording, too: candump lines by the demo recordings' layout, with the noise of
ordinary sensors of that seed. Needs the package commonroad-vehicle-models; ends with code 3 where that is absent.
"""

import csv
import math
import random
import struct
import sys

try:
    from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
    from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st
except ImportError as error:
    print(f"no commonroad-vehicle-models: {error}", file=sys.stderr)
    sys.exit(3)

STEP_S = 0.01
# Below this speed slip angles mean nothing, m/s.
SLOWEST = 1.0
# Standard deviations of the sensors' noise: yaw rate rad/s, lateral acceleration m/s², wheel speed rad/s.
NOISE = {"yaw_rate": 0.003, "lateral_acceleration": 0.06, "wheel": 0.05}
# Half tracks of the Golf, m: what the wheels' speeds tell of the yaw rate.
HALF_TRACKS = (0.77, 0.77, 0.76, 0.76)


def read(path):
    """Columns of a table by name."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [float(row[name] or "nan") for row in rows] for name in rows[0] if name}


class Along:
    """A column at any time, in straight lines."""

    def __init__(self, t, values):
        kept = [(t, value) for t, value in zip(t, values) if math.isfinite(value)]
        self.t, self.values = [t for t, _ in kept], [value for _, value in kept]
        self.place = 0

    def at(self, t):
        t = min(max(t, self.t[0]), self.t[-1])
        while self.place > 0 and self.t[self.place] > t:
            self.place -= 1
        while self.place + 2 < len(self.t) and self.t[self.place + 1] < t:
            self.place += 1
        i = self.place
        share = (t - self.t[i]) / (self.t[i + 1] - self.t[i])
        return self.values[i] + share * (self.values[i + 1] - self.values[i])


def smooth(values, points):
    """Means over so many points, the speed's slope needs them."""
    half = points // 2
    sums = [0.0]
    for value in values:
        sums.append(sums[-1] + value)
    ends = [(max(i - half, 0), min(i + half + 1, len(values))) for i in range(len(values))]
    return [(sums[to] - sums[first]) / (to - first) for first, to in ends]


def drive(samples, numbers):
    """Rows of time, steering wheel angle, speed, yaw rate, lateral acceleration."""
    car = parameters_vehicle2()
    for name in ("m", "I_z", "a", "b", "h_s"):
        setattr(car, name, numbers[name])
    car.tire.p_dy1 = numbers["friction"]
    car.tire.p_ky1 = -numbers["stiffness"] * numbers["friction"]
    # The recorded steering is what it is: the model's limits of it are out of the way.
    car.steering.v_min, car.steering.v_max = -100.0, 100.0
    t = samples["t"]
    wheels = [samples[f"wheel_speed_{wheel}"] for wheel in ("rl", "rr")]
    speed = smooth([numbers["radius"] * sum(pair) / 2 for pair in zip(*wheels)], 15)
    steering, speed = Along(t, samples["steering_wheel_angle"]), Along(t, speed)
    relaxes = numbers["relaxation"] > 0.0

    def driven(now):
        forward = speed.at(now)
        return max(forward, SLOWEST), (speed.at(now + 0.05) - speed.at(now - 0.05)) / 0.1

    def rates(now, state):
        """Of yaw rate, slip and what the tires feel of the steering angle and the motion."""
        yaw_rate, slip, lag_front, lag_rear = state
        v, a = driven(now)
        angle = steering.at(now) / numbers["ratio"]
        if not relaxes:
            f = vehicle_dynamics_st([0.0, 0.0, angle, v, 0.0, yaw_rate, slip], [0.0, a], car)
            return f[5], f[6], 0.0, 0.0
        # The linear tires of the same equations, each slip angle late by a length.
        wanted = (angle - slip - car.a * yaw_rate / v, -slip + car.b * yaw_rate / v)
        length = car.a + car.b
        loads = [(9.81 * car.b - a * car.h_s) / length, (9.81 * car.a + a * car.h_s) / length]
        stiff = numbers["friction"] * numbers["stiffness"]
        front, rear = (car.m * stiff * load * lag for load, lag in zip(loads, (lag_front, lag_rear)))
        lag = v / numbers["relaxation"]
        return (
            (car.a * front - car.b * rear) / car.I_z,
            (front + rear) / (car.m * v) - yaw_rate,
            lag * (wanted[0] - lag_front),
            lag * (wanted[1] - lag_rear),
        )

    state, rows = (0.0, 0.0, 0.0, 0.0), []
    for i in range(int((t[-1] - t[0]) / STEP_S)):
        now = t[0] + i * STEP_S
        first = rates(now, state)
        v, a = driven(now)
        rows.append((now, steering.at(now), v, state[0], v * (first[1] + state[0]) + a * state[1]))
        # Two steps by the midpoint rule: at walking pace slip angles settle quickly.
        for part in range(4):
            h, at = STEP_S / 4, now + part * STEP_S / 4
            half = rates(at, state)
            there = tuple(x + 0.5 * h * rate for x, rate in zip(state, half))
            state = tuple(x + h * rate for x, rate in zip(state, rates(at + 0.5 * h, there)))
    late = Along([row[0] for row in rows], [row[3] for row in rows])
    return [(t, angle, v, late.at(t - numbers["delay"]), across) for t, angle, v, _, across in rows]


def write_table(path, rows):
    """What explain reads; an angle and a yaw rate in degrees, as many programs have them."""
    with open(path, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(
            ["t [s]", "steering_wheel_angle [deg]", "vehicle_speed [m/s]", "yaw_rate [deg/s]",
             "lateral_acceleration [m/s^2]"]
        )
        for t, angle, v, yaw_rate, across in rows:
            table.writerow(
                [f"{t - rows[0][0]:.3f}", f"{math.degrees(angle):.6f}", f"{v:.6f}",
                 f"{math.degrees(yaw_rate):.6f}", f"{across:.6f}"]
            )


def write_log(path, rows, numbers, seed):
    """The same as a recording, with noise."""
    chance = random.Random(seed)

    def noisy(value, of, unit):
        raw = round((value + chance.gauss(0.0, NOISE[of])) / unit)
        return max(-32767, min(32767, raw))

    with open(path, "w") as file:
        for i, (_, angle, v, yaw_rate, across) in enumerate(rows):
            t = 1_600_000_000.0 + i * STEP_S
            sides = (-1.0, 1.0, -1.0, 1.0)
            speeds = [
                max(0, noisy((v + side * half * yaw_rate) / numbers["radius"], "wheel", 0.005))
                for side, half in zip(sides, HALF_TRACKS)
            ]
            inertial = (noisy(yaw_rate, "yaw_rate", 1e-4), noisy(across, "lateral_acceleration", 1e-3), -32768)
            for identifier, form, values in (
                ("1A0", "<4H", speeds),
                ("1B0", "<3h", inertial),
                ("1C0", "<2h", (round(angle / 0.0005), 0)),
            ):
                file.write(f"({t:.6f}) can0 {identifier}#{struct.pack(form, *values).hex().upper()}\n")


def main():
    arguments, log, seed = sys.argv[1:], None, 1
    if "--log" in arguments:
        place = arguments.index("--log")
        log = arguments[place + 1]
        del arguments[place : place + 2]
    if "--seed" in arguments:
        place = arguments.index("--seed")
        seed = int(arguments[place + 1])
        del arguments[place : place + 2]
    numbers = {
        "m": 1776.0, "I_z": 2900.0, "a": 1.19, "b": 1.44, "h_s": 0.55, "stiffness": 15.0, "friction": 1.0,
        "ratio": 12.33, "radius": 0.318, "delay": 0.0, "relaxation": 0.0,
    }
    for setting in arguments[2:]:
        name, value = setting.split("=")
        if name not in numbers:
            sys.exit(f"{name} is no number of the model; there are {', '.join(numbers)}")
        numbers[name] = float(value)
    rows = drive(read(arguments[0]), numbers)
    write_table(arguments[1], rows)
    if log:
        write_log(log, rows, numbers, seed)


main()
