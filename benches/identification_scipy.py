"""The problem of identification.rs for scipy and numba: C_x, C_y from slips and steering.

Prints what comes out and the least of five wall times; compiling and importing are not counted.
"""

import sys
import time

import numpy as np
from numba import njit
from scipy.optimize import least_squares

MASS, A, B, INERTIA, HALF_TRACK, DRAG, FRICTION = 1700.0, 1.5, 1.5, 1700.0, 0.75, 0.5, 1.0
LOAD = MASS * 9.81 / 4
STEP = 0.01
STD = np.array([0.011, 0.003, 0.07])  # speed, yaw rate, lateral acceleration
START = np.array([1.5e5, 4e4])


@njit
def rates(vx, vy, r, steer, fl, fr, rl, rr, cx, cy):
    sin, cos = np.sin(steer), np.cos(steer)
    along = vx * cos + (vy + A * r) * sin
    across = (vy + A * r) * cos - vx * sin
    limit = FRICTION * LOAD
    front = min(max(-cy * np.arctan(across / along), -limit), limit)
    rear = min(max(-cy * np.arctan((vy - B * r) / vx), -limit), limit)
    x = np.empty(4)
    y = np.empty(4)
    x[0], x[1], x[2], x[3] = cx * fl, cx * fr, cx * rl, cx * rr
    y[0], y[1], y[2], y[3] = front, front, rear, rear
    for i in range(4):
        x[i] = min(max(x[i], -limit), limit)
        used = (x[i] * x[i] + y[i] * y[i]) / (limit * limit)
        if used > 1.0:
            x[i] /= np.sqrt(used)
            y[i] /= np.sqrt(used)
    front_x, front_y = x[0] + x[1], y[0] + y[1]
    ax = (front_x * cos - front_y * sin + x[2] + x[3] - DRAG * vx * vx) / MASS
    ay = (front_x * sin + front_y * cos + y[2] + y[3]) / MASS
    moment = A * (front_x * sin + front_y * cos) - B * (y[2] + y[3])
    moment += HALF_TRACK * ((x[1] - x[0]) * cos + (y[0] - y[1]) * sin + x[3] - x[2])
    return ax + vy * r, ay - vx * r, moment / INERTIA, ay


@njit
def simulate(cx, cy, vx, vy, r, steer, slip, out):
    for k in range(len(steer) - 1):
        s = slip[k]
        a1, b1, c1, ay = rates(vx, vy, r, steer[k], s[0], s[1], s[2], s[3], cx, cy)
        out[k, 0], out[k, 1], out[k, 2] = vx, r, ay
        d = 0.5 * (steer[k] + steer[k + 1])
        m0, m1 = 0.5 * (s[0] + slip[k + 1, 0]), 0.5 * (s[1] + slip[k + 1, 1])
        m2, m3 = 0.5 * (s[2] + slip[k + 1, 2]), 0.5 * (s[3] + slip[k + 1, 3])
        h = 0.5 * STEP
        a2, b2, c2, _ = rates(vx + h * a1, vy + h * b1, r + h * c1, d, m0, m1, m2, m3, cx, cy)
        a3, b3, c3, _ = rates(vx + h * a2, vy + h * b2, r + h * c2, d, m0, m1, m2, m3, cx, cy)
        s, h = slip[k + 1], STEP
        a4, b4, c4, _ = rates(
            vx + h * a3, vy + h * b3, r + h * c3, steer[k + 1], s[0], s[1], s[2], s[3], cx, cy
        )
        vx += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        vy += h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
        r += h / 6 * (c1 + 2 * c2 + 2 * c3 + c4)


def main():
    table = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1)
    steer, slip = np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1:5])
    measured = table[:, 5:8]
    start = (measured[:10, 0].mean(), 0.0, measured[:10, 1].mean())
    out = np.zeros((len(steer), 3))

    def residuals(scaled):
        simulate(scaled[0] * START[0], scaled[1] * START[1], *start, steer, slip, out)
        return ((out - measured) / STD)[:-1].ravel()

    residuals(np.ones(2))
    best = np.inf
    for _ in range(5):
        begin = time.perf_counter()
        result = least_squares(residuals, np.ones(2))
        best = min(best, time.perf_counter() - begin)
    cx, cy = result.x * START
    print(f"scipy: C_x {cx:.6e}, C_y {cy:.6e} in {best:.4f} s, {result.nfev} evaluations beside the derivatives")
    print(f"seconds {best}")


if __name__ == "__main__":
    main()
