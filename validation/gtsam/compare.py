"""Solves the factor graph of `vibrissa map` with GTSAM, from dead reckoning on, and compares poses, shares and standard deviations."""

import json
import math
import sys
import time
from pathlib import Path

import gtsam
import numpy as np

SHARES = gtsam.symbol("s", 0)
STEP = 1e-6


def key(index):
    return gtsam.symbol("x", index)


def as_array(pose):
    return np.array([pose.x(), pose.y(), pose.theta()])



def factor(model, keys, residual):
    """A factor of this residual, with derivatives by central differences: none of the project's own."""

    def error(this, values, jacobians):
        at = [values.atVector(k) if k == SHARES else values.atPose2(k) for k in keys]
        told = residual(*at)
        if jacobians is not None:
            for place, value in enumerate(at):
                columns = []
                for axis in range(3):
                    step = np.zeros(3)
                    step[axis] = STEP
                    if keys[place] == SHARES:
                        forth, back = value + step, value - step
                    else:
                        forth, back = value.retract(step), value.retract(-step)
                    pair = [residual(*at[:place], v, *at[place + 1 :]) for v in (forth, back)]
                    columns.append((pair[0] - pair[1]) / (2.0 * STEP))
                jacobians[place] = np.array(columns).T.copy(order="F")
        return told

    return gtsam.CustomFactor(model, keys, error)


def leg_residual(leg, free):
    step, by_share = np.array(leg["step"]), np.array(leg["by_share"]) * free[:, None]

    def residual(before, after, shares):
        off = as_array(before.between(after)) - (step + shares @ by_share)
        off[2] = math.remainder(off[2], 2.0 * math.pi)
        return off

    return residual


def contact_residual(contact):
    p, q, normal = (np.array(contact[name]) for name in ("later_point", "earlier_point", "earlier_normal"))

    def residual(later, earlier):
        across = earlier.rotation().matrix() @ normal
        return np.array([across @ (later.transformFrom(p) - earlier.transformFrom(q))])

    return residual


def solve(graph):
    problem, start = gtsam.NonlinearFactorGraph(), gtsam.Values()
    first = gtsam.Pose2(*graph["poses"][0])
    problem.add(gtsam.NonlinearEqualityPose2(key(0), first))
    start.insert(key(0), first)
    prior = np.array(graph["shares_prior_std"])
    free = (prior > 0.0).astype(float)
    sigmas = np.where(prior > 0.0, prior, 1.0)
    problem.add(factor(gtsam.noiseModel.Diagonal.Sigmas(sigmas), [SHARES], lambda shares: np.array(shares)))
    start.insert(SHARES, np.zeros(3))
    pose = first
    for index, leg in enumerate(graph["legs"]):
        model = gtsam.noiseModel.Diagonal.Sigmas(np.array([leg["place_std"], leg["place_std"], leg["turn_std"]]))
        problem.add(factor(model, [key(index), key(index + 1), SHARES], leg_residual(leg, free)))
        pose = pose.compose(gtsam.Pose2(*leg["step"]))
        start.insert(key(index + 1), pose)
    for contact in graph["contacts"]:
        if contact["later"] != contact["earlier"]:
            model = gtsam.noiseModel.Isotropic.Sigma(1, contact["std"])
            keys = [key(contact["later"]), key(contact["earlier"])]
            problem.add(factor(model, keys, contact_residual(contact)))
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setRelativeErrorTol(1e-12)
    parameters.setAbsoluteErrorTol(1e-12)
    parameters.setMaxIterations(200)
    found = gtsam.LevenbergMarquardtOptimizer(problem, start, parameters).optimize()
    return problem, found


def compare(path):
    graph = json.loads(Path(path).read_text())
    began = time.perf_counter()
    problem, found = solve(graph)
    seconds = time.perf_counter() - began
    marginals = gtsam.Marginals(problem, found)
    off, turned, ratios = 0.0, 0.0, []
    for index, (ours, covariance) in enumerate(zip(graph["poses"], graph["covariances"])):
        theirs = as_array(found.atPose2(key(index)))
        off = max(off, float(np.hypot(*(theirs[:2] - ours[:2]))))
        turned = max(turned, abs(math.remainder(theirs[2] - ours[2], 2.0 * math.pi)))
        if index > 0:
            turn = np.eye(3)
            turn[:2, :2] = gtsam.Rot2(theirs[2]).matrix()
            own = turn @ marginals.marginalCovariance(key(index)) @ turn.T
            ratios.extend(np.sqrt(np.diag(covariance) / np.diag(own)))
    shares = np.abs(found.atVector(SHARES) - graph["shares"])
    return {
        "graph": Path(path).parent.name,
        "key poses": len(graph["poses"]),
        "contacts": len(graph["contacts"]),
        "cost, ours": graph["cost"],
        "cost, GTSAM": problem.error(found),
        "places differ by (mm)": 1e3 * off,
        "headings differ by (mrad)": 1e3 * turned,
        "shares differ by": float(shares.max()),
        "standard deviations, ours over GTSAM's": [min(ratios), max(ratios)],
        "seconds of GTSAM (derivatives in Python)": seconds,
    }


def main():
    wrong = False
    for path in sys.argv[1:]:
        row = compare(path)
        for name, value in row.items():
            print(f"{name}: {value}")
        least, most = row["standard deviations, ours over GTSAM's"]
        wrong |= row["places differ by (mm)"] > 1e-3 or least < 0.99 or most > 1.01
    sys.exit(1 if wrong else 0)


main()
