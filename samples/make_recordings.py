#!/usr/bin/env python3
"""Writes the recordings beside this file: what Table 1 of Tokuyasu et al. would give, with 1 % noise.

Equation (3) and the vertical element by Runge-Kutta 4 at 10 us: no code of the program. The noise is
white, 1 % of the range of what is measured; its seed is the place's name.
"""
import math
import pathlib
import random

# k_h1, k_h2, c_h, k_v, c_v
TABLE = {"base": (30.1, 766.5, 4.6, 90, 72), "middle": (164.8, 709.6, 2.1, 75, 60),
         "apex": (98.9, 655.4, 8.2, 45, 51)}
FINE_S = 1e-5


def half_cosine(t, start, length):
    share = min(max((t - start) / length, 0), 1)
    return 0.5 * (1 - math.cos(math.pi * share))


def integrate(rate, state, seconds, every_s):
    """Samples (t, state) of state' = rate(t, state)."""
    samples = [(0.0, state)]
    steps = round(every_s / FINE_S)
    for n in range(round(seconds / every_s)):
        for part in range(steps):
            t = n * every_s + part * FINE_S
            a = rate(t, state)
            b = rate(t + FINE_S / 2, state + FINE_S / 2 * a)
            c = rate(t + FINE_S / 2, state + FINE_S / 2 * b)
            d = rate(t + FINE_S, state + FINE_S * c)
            state += FINE_S / 6 * (a + 2 * b + 2 * c + d)
        samples.append(((n + 1) * every_s, state))
    return samples


def write(name, header, rows, noisy):
    draw = random.Random(name)
    values = [row[noisy] for row in rows]
    sigma = 0.01 * (max(values) - min(values))
    lines = [header]
    for row in rows:
        row = list(row)
        row[noisy] += draw.gauss(0, sigma)
        lines.append(",".join(f"{value:.6g}" for value in row))
    pathlib.Path(__file__).with_name(name).write_text("\n".join(lines) + "\n")


def relaxation(place):
    k1, k2, c, _, _ = TABLE[place]

    def stretch(t):  # the ventricle fills after it has let go
        return 3.5e-3 * half_cosine(t, 0.02, 0.12)

    def rate(t, branch):  # of the spring behind its damper
        speed = (stretch(t + 1e-7) - stretch(t - 1e-7)) / 2e-7
        return k1 * speed - k1 / c * branch

    # 0.5 N are left of the contraction; 0.2 N are what the force tends to.
    rows = [(t, 1e3 * stretch(t), k2 * stretch(t) + branch + 0.2)
            for t, branch in integrate(rate, 0.5, 0.6, 1e-3)]
    write(f"relaxation_{place}.csv", "t_s,stretch_mm,force_n", rows, 2)


def press(place):
    _, _, _, k, c = TABLE[place]

    def force(t):
        return 0.6 * (half_cosine(t, 0.1, 0.2) - half_cosine(t, 1.5, 0.1))

    rows = [(t, 1e3 * dent, force(t))
            for t, dent in integrate(lambda t, y: (force(t) - k * y) / c, 0.0, 4, 5e-3)]
    write(f"press_{place}.csv", "t_s,dent_mm,force_n", rows, 1)


for at in TABLE:
    relaxation(at)
    press(at)
