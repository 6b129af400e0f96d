"""One bent whisker with PyElastica: a damped dynamic rod that comes to rest under a force normal to its end."""

import sys

import elastica
import numpy as np
from beam_case import DENSITY, FORCE, LENGTH, RADIUS, S_A, TABLE, YOUNG, error
from elastica.timestepper.symplectic_steppers import PositionVerlet
from timing import once, row

SHEAR = YOUNG / 2.6


class World(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping):
    pass


class Follower(elastica.NoForces):
    """A force normal to the last element, let in over 5 ms."""

    def apply_forces(self, system, time=0.0):
        x, y, _ = system.tangents[:, -1]
        now = FORCE * min(1.0, time / 5e-3) / np.hypot(x, y)
        system.external_forces[0, -1] -= now * y
        system.external_forces[1, -1] += now * x


def built(elements):
    """The rod ends at the contact and begins half an element behind the clamp, which makes it second order."""
    h = S_A / (elements - 0.5)
    along, up, start = np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), np.array([-0.5 * h, 0, 0])
    world = World()
    rod = elastica.CosseratRod.straight_rod(
        elements, start, along, up, elements * h, RADIUS, DENSITY, youngs_modulus=YOUNG, shear_modulus=SHEAR
    )
    world.append(rod)
    # The explicit scheme's limit: axial waves, and the rotation of sections against shear.
    shear_mode = np.sqrt(27.0 / 28.0 * SHEAR * 4.0 / (DENSITY * RADIUS**2))
    step = 0.7 / np.hypot(np.sqrt(YOUNG / DENSITY) / h, 0.5 * shear_mode)
    world.constrain(rod).using(elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    world.add_forcing_to(rod).using(Follower)
    world.dampen(rod).using(elastica.AnalyticalLinearDamper, uniform_damping_constant=500.0, time_step=step)
    world.finalize()
    return world, rod, step


def settled(elements):
    world, rod, step = built(elements)
    verlet, time, before = PositionVerlet(), 0.0, np.zeros(2)
    while time < 0.15:
        for _ in range(2000):
            time = verlet.step(world, time, step)
        here = rod.position_collection[:2, -1].copy()
        if time > 0.02 and np.linalg.norm(here - before) < 1e-6 * LENGTH:
            break
        before = here
    return here


def main():
    elements = 20
    world, _, step = built(elements)
    PositionVerlet().step(world, 0.0, step)  # Compiles.
    place, time = once(lambda: settled(elements))
    row(TABLE, f"PyElastica {elastica.__version__ if hasattr(elastica, '__version__') else ''}, {elements} elements, to rest".replace(" ,", ","), [time], error(*place) + "; stretches and shears too")


if __name__ == "__main__":
    if "--short" in sys.argv:
        raise SystemExit("takes a minute, so the short form leaves it out")
    main()
