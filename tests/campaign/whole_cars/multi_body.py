#!/usr/bin/env python3
"""Drives CommonRoad's multi-body car and records it as a bus would, with one unusual thing in it or none.

    multi_body.py LOG TOML --vehicle 1|2|3 --scenario mixed|slalom|hard|highway [--seconds 90] [--seed 1] [NAME=VALUE ...]

LOG becomes candump lines by the layout of dbc/demo.dbc, TOML the car as its owner knows it: numbers of a data sheet that are
off within their standard deviations, tires guessed. The equations are the package's own (`vehicle_dynamics_mb`, 29 states). A
drive is straight stretches, curves, lane changes, slaloms and sweeps by that seed, up and down in speed. What would make the
car slide by more than 10 degrees, lift a wheel, lock or spin one, is driven more gently: the package has no ABS.

NAME=VALUE puts something unusual in:

    tire_radius_rl=-0.007       that wheel is so much smaller (relative), and turns faster
    yaw_delay=0.05              the yaw rate is so late, s; so is lateral_delay=0.05 the lateral acceleration
    yaw_scale=0.05              the yaw rate is so much too large, relative
    yaw_jump=0.02 at=45         another zero of the yaw rate from then on, rad/s
    steering_jump=0.1 at=45     another zero of the steering wheel's angle from then on, rad
    lateral_bias_drift=0.3      the lateral acceleration's zero moves by so much until the end, m/s²
    steering_lag=0.07           the road wheels follow the recorded steering wheel by a first-order lag, s
    steering_curvature=0.04     the steering ratio falls with the square of the steering wheel's angle, 1/rad²
    friction_patch=0.6 from=30 to=40    the road has so much of its friction there
    wind=1000 from=30 to=40     a side force to the left at the centre of gravity, N
    brake_pull=0.3              the left front brake gives so much more than the right one, relative

The package counts as SAE does: y to the right, z down. What is recorded counts as ISO 8855 does: y to the left, z up.

One thing of the package is smoothed: its tires jump where the camber changes its sign, by four per cent of the load, which no
tire does, and which no step size follows. Over 0.01 rad of camber the sign goes from one side to the other.

Needs the package commonroad-vehicle-models; ends with code 3 where that is absent, with 1 where the drive can not be driven.
"""

import argparse
import copy
import importlib
import math
import os
import random
import struct
import sys

try:
    from vehiclemodels.init_mb import init_mb
    from vehiclemodels.utils import tire_model
    from vehiclemodels.utils.acceleration_constraints import acceleration_constraints
    from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb
except ImportError as error:
    print(f"no commonroad-vehicle-models: {error}", file=sys.stderr)
    sys.exit(3)

GRAVITY = 9.81
# Of the integration, s. The stiffest is a wheel's turning at low speed: 1000 per second.
STEP_S = 0.001
# The package starts with the body 2 cm above where it hangs: so long it settles before the recording begins, s.
SETTLING_S = 4.0
# Camber over which the sign of the camber changes, rad.
CAMBER_SMOOTHING = 0.01
# What a driver does not do, rad and rad/s.
MOST_SIDESLIP = math.radians(10.0)
MOST_YAW_RATE = 0.6
MOST_SLIP = 0.08
# What is driven more gently begins so long before it went wrong, and 1.5 s more to get there.
EASED_S = 3.0
# Numbers of the cars that the package has not: steering ratio; brake torque of a front and a rear wheel at 1 bar, N m.
RATIO = {1: 16.0, 2: 15.0, 3: 18.0}
BRAKE_PER_BAR = 25.0
# Standard deviations of the sensors' noise: rad/s, m/s², rad, rad/s.
NOISE = {"yaw_rate": math.radians(0.18), "acceleration": 0.07, "steering": math.radians(0.05), "wheel": 0.05}
# Their constant errors are within these, rad/s, m/s², m/s², rad.
OFFSETS = {"yaw_rate": 0.003, "lateral": 0.08, "longitudinal": 0.08, "steering": 0.015}
UNUSUAL = (
    "tire_radius_rl", "yaw_delay", "lateral_delay", "yaw_scale", "yaw_jump", "steering_jump", "lateral_bias_drift",
    "steering_lag", "steering_curvature", "friction_patch", "wind", "brake_pull",
)
# Of speeds from and to, m/s, the most lateral acceleration, acceleration and braking, m/s², and how often which manoeuvre.
SCENARIOS = {
    "highway": (20.0, 30.0, 4.0, 1.5, 3.0, {"straight": 3, "curve": 4, "lane_change": 4, "sweep": 1}),
    "mixed": (8.0, 25.0, 6.0, 2.5, 4.0, {"straight": 2, "curve": 5, "lane_change": 3, "slalom": 1, "sweep": 1}),
    "slalom": (12.0, 22.0, 7.0, 2.0, 3.0, {"straight": 1, "curve": 1, "lane_change": 2, "slalom": 5, "sweep": 2}),
    "hard": (10.0, 28.0, 8.0, 3.0, 5.0, {"straight": 1, "curve": 5, "lane_change": 3, "slalom": 2, "sweep": 1}),
}


def smooth_sign(camber):
    """The sign in the package's tires, without its jump."""
    return math.tanh(camber / CAMBER_SMOOTHING)


tire_model.sign = smooth_sign


class Course:
    """What the driver means to do: lateral acceleration, speed and its change, every 10 ms."""

    GRID_S = 0.01

    def __init__(self, scenario, seconds, chance):
        slowest, fastest, self.lateral, self.speeding, self.braking, self.often = SCENARIOS[scenario]
        self.chance, self.points = chance, int(seconds / self.GRID_S) + 200
        self.v = smoothed(self.speeds(slowest, fastest), 50)
        self.a = [(late - early) / (2.0 * self.GRID_S) for early, late in zip(self.v, self.v[2:])]
        self.a = [self.a[0], *self.a, self.a[-1]]
        across = smoothed(self.manoeuvres(), 10)
        waves = [(chance.uniform(0.1, 0.5), chance.uniform(0.0, 6.3)) for _ in range(3)]
        for i, (v, a) in enumerate(zip(self.v, self.a)):
            # Who brakes or speeds up has less left for the curve.
            left = math.sqrt(max(0.15, 1.0 - (a / 7.0) ** 2))
            most = min(self.lateral * left, MOST_YAW_RATE * v)
            wander = sum(0.08 * math.sin(6.28 * f * i * self.GRID_S + phase) for f, phase in waves)
            across[i] = most * across[i] + wander
        self.y = smoothed(across, 10)
        # What is left of steering and of the pedals where it would be too much.
        self.eased, self.pedals = [1.0] * self.points, [1.0] * self.points

    def speeds(self, slowest, fastest):
        """Stretches of one speed, and from each to the next."""
        v = self.chance.uniform(slowest, fastest)
        values = []
        while len(values) < self.points:
            values += [v] * int(self.chance.uniform(1.5, 6.0) / self.GRID_S)
            other = self.chance.uniform(slowest, fastest)
            if abs(other - v) < 3.0:
                continue
            most = self.speeding if other > v else self.braking
            steps = int(abs(other - v) / (most * self.chance.uniform(0.4, 1.0)) / self.GRID_S)
            values += [v + (other - v) * i / steps for i in range(steps)]
            v = other
        return values[: self.points]

    def manoeuvres(self):
        """One after the other, as shares of the most lateral acceleration; straight on at first."""
        values = [0.0] * int(2.0 / self.GRID_S)
        names, weights = list(self.often), list(self.often.values())
        while len(values) < self.points:
            name = self.chance.choices(names, weights)[0]
            side = self.chance.choice((-1.0, 1.0))
            values += [side * value for value in getattr(self, name)()]
            values += [0.0] * int(self.chance.uniform(0.2, 1.2) / self.GRID_S)
        return values[: self.points]

    def straight(self):
        return [0.0] * int(self.chance.uniform(1.0, 4.0) / self.GRID_S)

    def curve(self):
        rise, hold, fall = (int(self.chance.uniform(*of) / self.GRID_S) for of in ((0.7, 1.8), (1.5, 5.0), (0.7, 1.8)))
        level = self.chance.uniform(0.4, 1.0)
        up = [level * 0.5 * (1.0 - math.cos(math.pi * i / rise)) for i in range(rise)]
        down = [level * 0.5 * (1.0 + math.cos(math.pi * i / fall)) for i in range(fall)]
        return up + [level] * hold + down

    def lane_change(self):
        length = int(self.chance.uniform(2.2, 4.0) / self.GRID_S)
        level = self.chance.uniform(0.5, 1.0)
        return [level * math.sin(2.0 * math.pi * i / length) for i in range(length)]

    def slalom(self):
        length = int(1.0 / self.chance.uniform(0.25, 0.6) / self.GRID_S)
        level, halves = self.chance.uniform(0.5, 1.0), self.chance.randint(4, 9)
        return [level * math.sin(2.0 * math.pi * i / length) for i in range(halves * length // 2)]

    def sweep(self):
        """From 0.2 to 1.3 Hz in 9 s."""
        level, seconds, first, last = self.chance.uniform(0.3, 0.6), 9.0, 0.2, 1.3
        values = []
        for i in range(int(seconds / self.GRID_S)):
            t = i * self.GRID_S
            ends = min(1.0, t, seconds - t)
            values.append(level * ends * math.sin(6.2832 * (first * t + (last - first) * t * t / (2.0 * seconds))))
        return values

    def ease(self, t, has_pedals):
        """Drives more gently around that time: what goes wrong at it began seconds before."""
        for i in range(self.points):
            away = max(t - EASED_S - i * self.GRID_S, i * self.GRID_S - t - 0.5, 0.0) / 1.5
            less = 1.0 - 0.12 * 0.5 * (1.0 + math.cos(math.pi * min(away, 1.0)))
            self.y[i] *= less
            self.eased[i] *= less
            self.pedals[i] *= less if has_pedals else 1.0

    def at(self, t, values):
        place = min(max(t / self.GRID_S, 0.0), len(values) - 1.001)
        i = int(place)
        return values[i] + (place - i) * (values[i + 1] - values[i])


def smoothed(values, half):
    """Means over so many points on each side, twice."""
    for _ in range(2):
        sums = [0.0]
        for value in values:
            sums.append(sums[-1] + value)
        ends = [(max(i - half, 0), min(i + half + 1, len(values))) for i in range(len(values))]
        values = [(sums[to] - sums[first]) / (to - first) for first, to in ends]
    return values


class Driver:
    """Turns the steering wheel for what is meant, and a little more for what is felt; speeds up and brakes."""

    LATE_S = 0.2
    QUICK = 12.0

    def __init__(self, course, car, ratio):
        self.course, self.ratio, self.length = course, ratio, car.a + car.b
        self.angle, self.rate, self.felt, self.wanted = 0.0, 0.0, 0.0, 0.0
        self.most = 0.85 * car.steering.v_max * ratio

    def step(self, now, v, yaw_rate):
        """The steering wheel's angle a step later, and the acceleration that is asked for."""
        course, slow = self.course, max(v, 5.0)
        turn = course.at(now, course.y) / slow
        missing = course.at(now - self.LATE_S, course.y) / slow - yaw_rate
        self.felt += STEP_S / 0.15 * (missing - self.felt)
        target = self.ratio * (self.length / slow * (turn + 0.6 * self.felt) + 0.001 * v * turn)
        self.rate += STEP_S * (self.QUICK**2 * (target - self.angle) - 2.0 * self.QUICK * self.rate)
        self.rate = min(max(self.rate, -self.most), self.most)
        self.angle += STEP_S * self.rate
        a = course.at(now, course.a) + 0.8 * (course.at(now, course.v) - v)
        # Nobody brakes for a trifle.
        a = min(a + 0.15, 0.0) if a < 0.0 else a
        a = min(max(a, -5.5), 3.2) * course.at(now, course.pedals)
        self.wanted += STEP_S / 0.15 * (a - self.wanted)
        return self.angle, self.wanted


def loads(x, car):
    """Of the four wheels, N, as the package has them."""
    front, rear = (car.R_w * (math.cos(x[roll]) - 1.0) + x[z] for roll, z in ((13, 16), (18, 21)))
    lean = 0.5 * car.T_f * math.sin(x[13]), 0.5 * car.T_r * math.sin(x[18])
    return [car.K_zt * load for load in (front - lean[0], front + lean[0], rear - lean[1], rear + lean[1])]


def slips(x, car):
    """Of the four wheels along themselves, as the package has them but for the sign."""
    half_front, half_rear = 0.5 * car.T_f * x[5], 0.5 * car.T_r * x[5]
    across = (x[10] + car.a * x[5]) * math.sin(x[2])
    along = [(x[3] + side * half_front) * math.cos(x[2]) + across for side in (1.0, -1.0)]
    along += [x[3] + half_rear, x[3] - half_rear]
    return [car.R_w * x[23 + wheel] / along[wheel] - 1.0 for wheel in range(4)]


def drive(car, ratio, course, seconds, unusual):
    """Every millisecond what sensors and bus could tell; counted as ISO does."""
    driver = Driver(course, car, ratio)
    x = init_mb([0.0, 0.0, 0.0, course.v[0], 0.0, 0.0, 0.0], car)
    friction = car.tire.p_dx1, car.tire.p_dy1
    curvature, lag = unusual.get("steering_curvature", 0.0), unusual.get("steering_lag", 0.0)
    follows = 1.0 - math.exp(-STEP_S / lag) if lag > 0.0 else 1.0
    rows, began = [], []

    def rates(x, u, wind, pull):
        f = vehicle_dynamics_mb(x, u, car)
        f[10] += wind / car.m_s
        f[23] -= pull / car.I_y_w
        return f

    i, every = -round(SETTLING_S / STEP_S), round(1.0 / STEP_S)
    while i <= round(seconds / STEP_S):
        now = i * STEP_S
        if i >= 0 and i % every == 0:
            began.append((i, x, copy.copy(driver)))
        angle, wanted = driver.angle, 0.0
        if i >= 0:
            after, wanted = driver.step(now, x[3], -x[5])
        else:
            after = angle
        road = -after / (ratio * max(1.0 - curvature * after * after, 0.2))
        u = [(road - x[2]) * follows / STEP_S, acceleration_constraints(x[3], wanted, car.longitudinal)]
        # What the package makes of it: torque of all driven wheels, and brake pressure.
        drive_torque = car.m * car.R_w * max(u[1], 0.0)
        pressure = car.m * car.R_w * max(-u[1], 0.0) / (2.0 * BRAKE_PER_BAR)
        # The wind and another road come within half a second.
        inside = min(now - unusual["from"], unusual["to"] - now) / 0.5
        inside = min(max(inside, 0.0), 1.0)
        wind = -unusual.get("wind", 0.0) * inside
        share = 1.0 - (1.0 - unusual.get("friction_patch", 1.0)) * inside
        car.tire.p_dx1, car.tire.p_dy1 = (share * of for of in friction)
        pull = unusual.get("brake_pull", 0.0) * BRAKE_PER_BAR * car.T_sb * pressure
        first = rates(x, u, wind, pull)
        if i >= 0:
            least = min(loads(x, car))
            sideslip = -math.atan2(x[10], x[3])
            slip = max(map(abs, slips(x, car))) if x[3] > 3.0 else 1.0
            if abs(sideslip) > MOST_SIDESLIP or least < 0.0 or slip > MOST_SLIP:
                course.ease(now, slip > MOST_SLIP)
                if min(course.eased) < 0.1:
                    angle = math.degrees(sideslip)
                    sys.exit(f"at {now:.1f} s: sideslip {angle:.1f}°, least load {least:.0f} N, a wheel's slip {slip:.2f}")
                # Once more from before it.
                del began[max(int(now - EASED_S - 2.0), 0) + 1 :]
                i, x, driver = began.pop()
                del rows[i:]
                continue
            of_bus = (*x[23:27], angle, drive_torque, pressure)
            rows.append(felt(x, first) + of_bus + (x[3], sideslip, least, slip))
        half = 0.5 * STEP_S
        second = rates([s + half * rate for s, rate in zip(x, first)], u, wind, pull)
        third = rates([s + half * rate for s, rate in zip(x, second)], u, wind, pull)
        fourth = rates([s + STEP_S * rate for s, rate in zip(x, third)], u, wind, pull)
        sixth = STEP_S / 6.0
        x = [s + sixth * (a + 2.0 * (b + c) + d) for s, a, b, c, d in zip(x, first, second, third, fourth)]
        i += 1
    car.tire.p_dx1, car.tire.p_dy1 = friction
    return rows


def felt(x, f):
    """What sensors in the leaning body feel: yaw rate, lateral and longitudinal acceleration."""
    roll, pitch = x[6], x[8]
    # Acceleration of its centre of gravity, less gravity.
    along, across, down = f[3] - x[5] * x[10], f[10] + x[5] * x[3], f[12] - GRAVITY
    forward = along * math.cos(pitch) - down * math.sin(pitch)
    below = along * math.sin(pitch) + down * math.cos(pitch)
    right = across * math.cos(roll) + below * math.sin(roll)
    turning = x[5] * math.cos(pitch) * math.cos(roll) - x[9] * math.sin(roll)
    return -turning, -right, forward


# Places in a row.
YAW_RATE, LATERAL, LONGITUDINAL, WHEELS, STEERING, TORQUE, PRESSURE, SPEED, SIDESLIP, LEAST, SLIP = 0, 1, 2, 3, *range(7, 14)


def write_log(path, rows, seconds, radius, unusual, chance):
    """Frames of four messages, each with its own phase and a little jitter."""
    offset = {name: chance.uniform(-most, most) for name, most in OFFSETS.items()}
    late = {YAW_RATE: unusual.get("yaw_delay", 0.0), LATERAL: unusual.get("lateral_delay", 0.0)}
    rl = 1.0 / (1.0 + unusual.get("tire_radius_rl", 0.0))

    def value(of, t):
        place = min(max((t - late.get(of, 0.0)) / STEP_S, 0.0), len(rows) - 1.001)
        i = int(place)
        return rows[i][of] + (place - i) * (rows[i + 1][of] - rows[i][of])

    def noisy(value, of, unit, least=-32767, most=32767):
        raw = round((value + (chance.gauss(0.0, NOISE[of]) if of else 0.0)) / unit)
        return max(least, min(most, raw))

    def wheels(t, _):
        kmh = 3.6 * radius
        speeds = [value(WHEELS + wheel, t) * (rl if wheel == 2 else 1.0) for wheel in range(4)]
        return struct.pack("<4H", *(noisy(speed, "wheel", 0.01 / kmh, 0, 65000) for speed in speeds))

    def inertial(t, count):
        has_jumped = t >= unusual["at"]
        yaw_rate = (1.0 + unusual.get("yaw_scale", 0.0)) * value(YAW_RATE, t) + offset["yaw_rate"]
        yaw_rate += unusual.get("yaw_jump", 0.0) if has_jumped else 0.0
        across = value(LATERAL, t) + offset["lateral"] + unusual.get("lateral_bias_drift", 0.0) * t / seconds
        along = value(LONGITUDINAL, t) + offset["longitudinal"]
        return struct.pack(
            "<2B3h", 0, count % 15, noisy(yaw_rate, "yaw_rate", math.radians(0.01)),
            noisy(across, "acceleration", 0.002), noisy(along, "acceleration", 0.002),
        )

    def steering(t, _):
        jump = unusual.get("steering_jump", 0.0) if t >= unusual["at"] else 0.0
        angle = noisy(value(STEERING, t) + offset["steering"] + jump, "steering", math.radians(0.1))
        return struct.pack("<h2B", angle, 1, 0)

    def drives(t, _):
        pressure = noisy(value(PRESSURE, t), "", 0.1, 0, 4000)
        bits = pressure | (1 << 12 if pressure > 5 else 0)
        return struct.pack("<hI", noisy(value(TORQUE, t), "", 1.0), bits)

    lines = []
    for identifier, period, payload in (
        ("1A0", 0.02, wheels), ("1B0", 0.01, inertial), ("1C0", 0.01, steering), ("1D0", 0.02, drives),
    ):
        phase = chance.uniform(0.0, period)
        for count in range(int((seconds - phase) / period)):
            t = phase + count * period
            stamp = t + min(abs(chance.gauss(0.0, 0.0002)), 0.001)
            lines.append((stamp, f"can0 {identifier}#{payload(t, count).hex().upper()}\n"))
    lines.sort()
    with open(path, "w") as file:
        file.writelines(f"({1_600_000_000.0 + stamp:.6f}) {line}" for stamp, line in lines)


def known(vehicle, car, chance):
    """The [vehicle] table: numbers with their standard deviations, relative, and what is known for sure."""
    tire, length = car.tire, car.a + car.b
    driven_load = {1: car.b, 0: car.a}[car.T_se] / length

    def about(value, std):
        told = value * (1.0 + std * chance.uniform(-1.0, 1.0))
        return f"{{ value = {told:.6g}, std = {std * value:.3g} }}", told

    uncertain = [
        ("mass_kg", car.m, 0.03), ("cg_to_front_m", car.a, 0.02), ("yaw_inertia_kgm2", car.I_z, 0.08),
        ("wheel_radius_m", car.R_w, 0.008), ("wheel_inertia_kgm2", car.I_y_w, 0.05),
        ("steering_ratio", RATIO[vehicle], 0.01),
        # The longitudinal one is a driven wheel's, over a quarter of the weight.
        ("longitudinal_stiffness", tire.p_kx1 * 2.0 * driven_load, 0.1),
        ("lateral_stiffness_front", -tire.p_ky1, 0.15), ("lateral_stiffness_rear", -tire.p_ky1, 0.15),
        ("friction", tire.p_dy1, 0.05),
    ]
    numbers = {name: about(value, std) for name, value, std in uncertain}
    table = {name: text for name, (text, _) in numbers.items()}
    table |= {
        "wheelbase_m": f"{length:.4f}",
        "track_front_m": f"{car.T_f:.3f}",
        "track_rear_m": f"{car.T_r:.3f}",
        "driven_axle": '"front"' if car.T_se == 1 else '"rear"',
        "drive_torque_ratio": "1.0",
        "brake_torque_per_bar_front_nm": f"{BRAKE_PER_BAR * car.T_sb:.3f}",
        "brake_torque_per_bar_rear_nm": f"{BRAKE_PER_BAR * (1.0 - car.T_sb):.3f}",
        "tire": '"magic_formula"',
        "magic_formula_shape": f"{tire.p_cy1:.3f}",
        "magic_formula_curvature": f"{tire.p_ey1:.4f}",
    }
    return table, numbers["wheel_radius_m"][1]


def write_toml(path, table):
    dbc = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "dbc", "demo.dbc")
    signals = {f"wheel_speed_{wheel}": f"WHEELS.Speed{wheel.upper()}" for wheel in ("fl", "fr", "rl", "rr")}
    signals |= {
        "yaw_rate": "INERTIAL.YawRate",
        "lateral_acceleration": "INERTIAL.AccelerationY",
        "longitudinal_acceleration": "INERTIAL.AccelerationX",
        "steering_wheel_angle": "STEERING.Angle",
        "drive_torque": "DRIVE.AxleTorque",
        "brake_pressure": "DRIVE.BrakePressure",
    }
    with open(path, "w") as file:
        file.write("# What a user knows of this car: data-sheet values with their uncertainty, tire stiffness guessed.\n")
        file.write(f'[dbc]\ninput = ["{os.path.normpath(dbc)}"]\n\n[signals]\n')
        file.writelines(f'{name} = "{signal}"\n' for name, signal in signals.items())
        file.write("\n[vehicle]\n")
        file.writelines(f"{name} = {text}\n" for name, text in table.items())


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("log")
    parser.add_argument("toml")
    parser.add_argument("--vehicle", type=int, choices=(1, 2, 3), required=True)
    parser.add_argument("--scenario", choices=SCENARIOS, required=True)
    parser.add_argument("--seconds", type=float, default=90.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("unusual", nargs="*", metavar="NAME=VALUE")
    asked = parser.parse_intermixed_args()
    # Where nothing else is said, things begin then.
    unusual = {"at": 45.0, "from": 30.0, "to": 40.0}
    for setting in asked.unusual:
        name, _, value = setting.partition("=")
        if name not in (*UNUSUAL, *unusual):
            parser.error(f"{name} is nothing unusual; there are {', '.join(UNUSUAL)}")
        unusual[name] = float(value)
    return asked, unusual


def main():
    asked, unusual = arguments()
    module = importlib.import_module(f"vehiclemodels.parameters_vehicle{asked.vehicle}")
    car = getattr(module, f"parameters_vehicle{asked.vehicle}")()
    # One axle is driven: that which has most of it.
    car.T_se = round(car.T_se)
    course = Course(asked.scenario, asked.seconds, random.Random(asked.seed))
    rows = drive(car, RATIO[asked.vehicle], course, asked.seconds, unusual)
    chance = random.Random(1000 + asked.seed)
    table, radius = known(asked.vehicle, car, chance)
    write_toml(asked.toml, table)
    write_log(asked.log, rows, asked.seconds, radius, unusual, chance)
    ranges = ", ".join(
        f"{name} {min(row[of] for row in rows):.3g} to {max(row[of] for row in rows):.3g} {unit}"
        for name, of, unit in (
            ("speed", SPEED, "m/s"), ("lateral", LATERAL, "m/s²"), ("along", LONGITUDINAL, "m/s²"),
            ("yaw rate", YAW_RATE, "rad/s"), ("steering", STEERING, "rad"), ("sideslip", SIDESLIP, "rad"),
            ("torque", TORQUE, "N m"), ("pressure", PRESSURE, "bar"), ("least load", LEAST, "N"),
            ("most slip", SLIP, "of a wheel"),
        )
    )
    eased = sum(share < 0.99 for share in course.eased) * course.GRID_S
    print(f"{ranges}; driven more gently for {eased:.0f} s, down to {min(course.eased):.2f} of what was meant")


main()
