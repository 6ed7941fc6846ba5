#!/usr/bin/env python3
"""Paper B's ventricle, natural and pressed, by an integration that shares no line with the program's.

usage: loop_test.py BEATLAS_PLAY   (exit 0: every figure of `--press` within 0.1 % of SciPy's)

The equations are those of runtime/palpation/circulation.h, muscle.h, patch.h and trainer.h, written down anew:
an ordinary differential equation of volume, vessel, branch and dent, solved by LSODA from one change of regime
to the next. The wall's mass, 1.14 g, is left out: its pole lies at 5e4 a second.
"""
import json
import math
import subprocess
import sys
import tempfile

import numpy
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

PA = 133.322387415                      # of a mmHg
TABLE = ((30.1, 766.5, 4.6), (164.8, 709.6, 2.1), (98.9, 655.4, 8.2))  # K_h1, K_h2, C_h
K_V, C_V, K_C = 75.0, 60.0, 800.0       # N/m, N s/m, N/m
EMIN, EMAX, V0 = 0.19, 4.5, 5.0         # mmHg/ml, mmHg/ml, ml
R, ZC, C, R_AV, R_MV = 2.38, 0.104, 0.57, 0.008, 0.012
LAP, RAP, RATE = 9.0, 7.0, 110.0
S_C, S, STOP, V_REF = 14.1, 3.0, 2e4, 49.8  # cm2, cm2, N/m, ml
LAMBDA = sum(k1 / c for k1, _, c in TABLE) / 3
BRANCH = EMIN * sum(row[0] for row in TABLE) / sum(row[1] for row in TABLE)
PERIOD = 60 / RATE
DIAMETER = (4 * V_REF / (math.pi * 1.6)) ** (1 / 3)  # cm
LENGTH = 1.6 * DIAMETER
SIDE = math.pi * DIAMETER * LENGTH                   # cm2


def activation():
    """e(t) and where it begins to decay by the relaxation rate (Stergiopulos et al. 1996)."""
    def shape(x):
        rise = (x / 0.303) ** 1.32
        return rise / (1 + rise) / (1 + (x / 0.508) ** 21.9)

    def log_slope(x):
        rise, fall = (x / 0.303) ** 1.32, (x / 0.508) ** 21.9
        return (1.32 / (1 + rise) - 21.9 * fall / (1 + fall)) / x
    joint = brentq(lambda x: log_slope(x) + LAMBDA * PERIOD, 0.2, 0.5847, xtol=1e-14)

    def unscaled(x):
        return shape(x) if x < joint else shape(joint) * math.exp(-LAMBDA * PERIOD * (x - joint))
    end = unscaled(1.0)
    highest = -minimize_scalar(lambda x: x * end - unscaled(x), bounds=(0.2, joint), method="bounded",
                               options={"xatol": 1e-12}).fun
    return (lambda t: (unscaled(t / PERIOD) - t / PERIOD * end) / highest if t > 0 else 0.0), joint * PERIOD


E_OF, JOINT = activation()


class Ventricle:
    """Beats with a finger `depth` m below the wall of end-diastole; below 0: without one."""

    def __init__(self, depth: float) -> None:
        self.depth = depth
        self.y = numpy.array([V_REF, 90.0, 0.0, 0.0])  # ml, mmHg, mmHg, m
        self.left = 0.0     # of the contraction's pressure, at the moment of letting go
        self.length = 1.0   # V_x - V0
        self.section = 7.3  # S_n, cm2

    def finger(self, volume: float) -> float:
        squeezed = self.depth + 1e-6 * (volume - V_REF) / (1e-4 * S_C)
        return STOP * squeezed if self.depth > 0 and squeezed > 0 else 0.0

    def flows(self, t: float, y, contracting: bool):
        volume, vessel, branch, _ = y
        active = (EMAX - EMIN) * E_OF(t) * (volume - V0) if contracting else 0.0
        since = t if contracting else t - JOINT
        passing = self.left * math.exp(-LAMBDA * since) * min(1.0, (volume - V0) / self.length)
        pressure = (EMIN * (volume - V0) + branch + active + passing +
                    self.finger(volume) / (1e-4 * S_C * PA))
        mitral = max(0.0, (LAP - pressure) / R_MV)
        aortic = max(0.0, (pressure - vessel) / (R_AV + ZC))
        return pressure, mitral, aortic

    def felt(self, t: float, y) -> tuple[float, float, float]:
        """Force [N], spring [N/m] and damper [N s/m] of the wall under the finger."""
        volume, _, branch, dent = y
        out = 0.01 * (volume - V_REF) / SIDE
        share = S_C / SIDE
        wall = (out + share * self.depth) / (1 - share) if self.depth + out > 0 else out
        elastance = EMIN + (EMAX - EMIN) * E_OF(t)
        filling = max(0.0, EMIN * (volume - V0) + branch)
        stiffness = (K_V + self.section * S * 1e-8 * elastance * PA * 1e6 +
                     math.pi * PA * filling * 0.005 * DIAMETER)
        spring = stiffness * K_C / (K_C - stiffness)
        return max(0.0, K_C * (self.depth + wall - dent)), spring, C_V * spring / stiffness

    def rates(self, t: float, y, contracting: bool):
        _, mitral, aortic = self.flows(t, y, contracting)
        force, spring, damper = self.felt(t, y) if self.depth > 0 else (0.0, 1.0, 1.0)
        return [mitral - aortic, (aortic - (y[1] - RAP) / R) / C,
                (0.0 if contracting else BRANCH * (mitral - aortic)) - LAMBDA * y[2],
                (force - spring * y[3]) / damper]

    def beat(self) -> dict[str, float]:
        seen, stroke = [], 0.0
        for contracting, start, stop in ((True, 0.0, JOINT), (False, JOINT, PERIOD)):
            grid = numpy.linspace(start, stop, 1500)
            found = solve_ivp(self.rates, (start, stop), self.y, "LSODA", grid, args=(contracting,), rtol=1e-8,
                              atol=1e-9, max_step=5e-4)
            rows = numpy.array([self.flows(t, y, contracting) for t, y in zip(grid, found.y.T)])
            stroke += numpy.trapz(rows[:, 2], grid)
            seen.append((grid, found.y, rows))
            self.y = found.y[:, -1]
            if contracting:
                active = (EMAX - EMIN) * E_OF(JOINT) * (self.y[0] - V0)
                left = self.left * math.exp(-LAMBDA * JOINT) * min(1.0, (self.y[0] - V0) / self.length)
                self.left, self.length = left + active, self.y[0] - V0
                section = numpy.trapz(found.y[0], grid) / JOINT / LENGTH
            else:
                self.left *= math.exp(-LAMBDA * (PERIOD - JOINT))
        volume = numpy.concatenate([y[0] for _, y, _ in seen])
        aorta = sum(numpy.trapz(y[1] + ZC * rows[:, 2], grid) for grid, y, rows in seen) / PERIOD
        self.section = section
        return {"edv_ml": volume.max(), "esv_ml": volume.min(), "stroke_ml": stroke,
                "output_l_per_min": stroke * RATE / 1000, "aortic_mean_mmhg": aorta,
                "peak_lv_mmhg": max(rows[:, 0].max() for _, _, rows in seen),
                "diastole_n": self.felt(0.0, self.y)[0] if self.depth > 0 else 0.0}


def settled(depth: float) -> dict[str, float]:
    ventricle, before = Ventricle(depth), -1.0
    for _ in range(80):
        found = ventricle.beat()
        if abs(found["stroke_ml"] - before) < 1e-6:
            return found
        before = found["stroke_ml"]
    raise SystemExit("loop_test: the reference does not settle")


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        said = subprocess.run([sys.argv[1], "--headless", "--scene", "palpation", "--press", folder, "--json"],
                              check=True, capture_output=True, text=True).stdout
    press = json.loads(said)
    natural, pressed = settled(-1.0), settled(0.008)
    healthy = next(one for one in press["tissues"] if one["name"] == "healthy")
    pairs = [(f"{loop}/{name}", press[loop][name], value)
             for loop, found in (("natural", natural), ("pressed", pressed))
             for name, value in found.items() if name != "diastole_n"]
    pairs.append(("pressed/diastole_n", healthy["in_space"]["diastole_n"], pressed["diastole_n"]))
    worst = 0.0
    for name, ours, reference in pairs:
        off = abs(ours / reference - 1)
        worst = max(worst, off)
        print(f"{name:28} {ours:10.5f} {reference:10.5f} {100 * off:8.4f} %")
    print(f"worst {100 * worst:.4f} %, allowed 0.1 %")
    return 0 if worst <= 1e-3 else 1


if __name__ == "__main__":
    sys.exit(main())
