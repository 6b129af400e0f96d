"""One bent whisker with MuJoCo's cable (version 3): rigid links with elastic joints that come to rest."""

import mujoco
import numpy as np
from beam_case import DENSITY, FORCE, LENGTH, RADIUS, S_A, TABLE, YOUNG, error
from timing import once, row


def built(links):
    # Begins half a link behind the clamp, so that joints sit in the middle of what they stand for.
    h = S_A / (links - 0.5)
    damping = 5e-3 * YOUNG * 0.25 * np.pi * RADIUS**4 / h
    text = f"""
    <mujoco>
      <extension><plugin plugin="mujoco.elasticity.cable"/></extension>
      <option timestep="1e-3" gravity="0 0 0" integrator="implicitfast"><flag contact="disable"/></option>
      <worldbody>
        <composite prefix="c" type="cable" curve="s" count="{links + 1} 1 1" size="{links * h}" offset="{-0.5 * h} 0 0" initial="none">
          <plugin plugin="mujoco.elasticity.cable">
            <config key="twist" value="{YOUNG / 2.6}"/><config key="bend" value="{YOUNG}"/>
          </plugin>
          <joint kind="main" damping="{damping}"/>
          <geom type="cylinder" size="{RADIUS}" density="{DENSITY}"/>
        </composite>
      </worldbody>
    </mujoco>"""
    return mujoco.MjModel.from_xml_string(text), h


def settled(model, h):
    data, last, pushed = mujoco.MjData(model), model.nbody - 1, np.zeros(model.nv)
    mujoco.mj_forward(model, data)
    before = np.zeros(2)
    while data.time < 0.5:
        turn = data.xmat[last].reshape(3, 3)
        end = data.xpos[last] + h * turn[:, 0]
        force = FORCE * min(1.0, data.time / 0.02) * np.array([-turn[1, 0], turn[0, 0], 0.0])
        pushed[:] = 0.0
        mujoco.mj_applyFT(model, data, force, np.zeros(3), end, last, pushed)
        data.qfrc_applied[:] = pushed
        mujoco.mj_step(model, data)
        if data.time > 0.03 and np.linalg.norm(end[:2] - before) < 1e-8 * LENGTH:
            break
        before = end[:2].copy()
    return end[:2]


def main():
    for links in (20, 60):
        model, h = built(links)
        found = [once(lambda: settled(model, h)) for _ in range(3)]
        row(TABLE, f"MuJoCo {mujoco.__version__} cable, {links} links, to rest", [time for _, time in found], error(*found[0][0]))


if __name__ == "__main__":
    main()
