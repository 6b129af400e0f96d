#!/usr/bin/env python3
"""Contacts of a whisker in space by PyElastica: Cosserat rods, which share nothing with this project's mechanics.

A straight round rod is clamped at the origin and points along +x. A point that gives no friction stands beside it and is moved, step by
step, as a point at rest seems to move for a whisker whose base drives in the plane x-y. What the base feels and where the rod is touched
goes to contacts.csv.

Usage: make_table.py [CASE …]     writes contacts.csv beside itself; needs `pip install pyelastica`
"""

import sys
from pathlib import Path

import elastica as ea
import numpy as np

LENGTH = 0.075
RIGIDITY = 2.8886e-4
# Thicker than the wire of this rigidity, so that time steps are longer; it is stretched by less than 1e-4 for that.
RADIUS = 0.5e-3
ELEMENTS = 50
# The clamp holds the first element as a whole: the rod begins half an element before the origin, so that it bends from there on.
STEP = LENGTH / (ELEMENTS - 0.5)
# Force for each metre between the point and the rod's axis (N/m); the place told is the one on the axis.
STIFFNESS = 1500.0

# A name, the point (m) as the whisker sees it at the beginning, and the way of the base (m, m) between two of its five places.
CASES = [
    ("in_plane", (0.050, 0.004, 0.0), (0.0, 0.0016)),
    ("diagonal", (0.055, 0.003, 0.003), (0.0006, 0.0016)),
    ("above", (0.045, 0.001, 0.004), (-0.0008, 0.0014)),
    ("below_left", (0.060, 0.004, -0.005), (0.0006, 0.0018)),
    ("right", (0.040, -0.0025, 0.0015), (0.0012, -0.0012)),
    ("under", (0.058, -0.002, -0.006), (0.0, -0.0020)),
    ("bent_far", (0.052, 0.006, 0.004), (0.0, 0.0060)),
    ("bent_far_right", (0.046, -0.005, -0.012), (0.0, -0.0050)),
]
STEPS = 5


class Hand:
    """Where the point is put, and what came of it: place on the axis, force, arc length."""

    def __init__(self, point):
        self.point = np.array(point)
        self.told = None


class PointWithoutFriction(ea.NoForces):
    """A spring from a moving point to the nearest place of the rod's axis, across the axis."""

    def __init__(self, hand):
        self.hand = hand

    def nearest(self, nodes):
        start, edge = nodes[:, :-1], np.diff(nodes)
        share = np.clip(((self.hand.point[:, None] - start) * edge).sum(0) / (edge * edge).sum(0), 0.0, 1.0)
        gap = self.hand.point[:, None] - (start + share * edge)
        index = int(np.argmin((gap * gap).sum(0)))
        return index, share[index], gap[:, index]

    def apply_forces(self, system, time=0.0):
        index, share, gap = self.nearest(system.position_collection)
        force = STIFFNESS * gap
        system.external_forces[:, index] += (1.0 - share) * force
        system.external_forces[:, index + 1] += share * force
        nodes = system.position_collection
        place = nodes[:, index] + share * (nodes[:, index + 1] - nodes[:, index])
        arc = (index + share - 0.5) * STEP
        self.hand.told = (place, force, arc)


class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):
    pass


def settle(hand, stepper, simulator, time, dt, rod):
    """Runs until the moment about the base stands still."""
    last = None
    for _ in range(600):
        for _ in range(1000):
            time = stepper.step(simulator, time, dt)
        place, force, _ = hand.told
        moment = np.cross(place, force)
        still = np.abs(rod.velocity_collection).max()
        if last is not None and np.abs(moment - last).max() < 2e-9 and still < 5e-5:
            return time
        last = moment
    raise SystemExit(f"no rest: {moment} {last} {still}")


def run(name, start, way):
    young = RIGIDITY / (np.pi * RADIUS**4 / 4.0)
    rod = ea.CosseratRod.straight_rod(
        ELEMENTS,
        np.array([-0.5 * STEP, 0.0, 0.0]),
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, 0.0, 1.0]),
        STEP * ELEMENTS,
        RADIUS,
        6500.0,
        youngs_modulus=young,
        shear_modulus=young / 2.6,
    )
    simulator = Simulator()
    simulator.append(rod)
    simulator.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    hand = Hand((start[0], 0.0, 0.0))
    simulator.add_forcing_to(rod).using(PointWithoutFriction, hand=hand)
    speed = np.sqrt(young / 6500.0)
    dt = 0.35 * STEP / speed
    simulator.dampen(rod).using(ea.AnalyticalLinearDamper, uniform_damping_constant=400.0, time_step=dt)
    simulator.finalize()
    stepper, time = ea.PositionVerlet(), 0.0
    rows = []
    # From the axis to the beginning, in small steps: first sideways, then up.
    for share in np.linspace(0.0, 1.0, 9)[1:]:
        hand.point = np.array([start[0], share * start[1], share * start[2]])
        for _ in range(1500):
            time = stepper.step(simulator, time, dt)
    for step in range(STEPS):
        base = np.array([way[0] * step, way[1] * step, 0.0])
        # The base drives away from the point, so that the whisker bends more.
        hand.point = np.array(start) + np.array([base[0], base[1], 0.0])
        time = settle(hand, stepper, simulator, time, dt, rod)
        place, force, arc = hand.told
        felt = np.cross(place, force)
        rows.append([name, step, -base[0], -base[1], *place, arc, felt[2], -felt[1], felt[0], np.linalg.norm(force)])
        print(name, step, " ".join(f"{v:.6g}" for v in rows[-1][2:]), flush=True)
    return rows


def main():
    wanted = sys.argv[1:]
    rows = [row for case in CASES if not wanted or case[0] in wanted for row in run(*case)]
    lines = ["case,step,base_x,base_y,x,y,z,s_a,moment,across,twist,force"]
    lines += [",".join([row[0], str(row[1])] + [f"{value:.9g}" for value in row[2:]]) for row in rows]
    Path(__file__).with_name("contacts.csv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
