"""Runs `first_order.m` in Octave, where there is one."""

import os
import pathlib
import shutil
import subprocess
import sys

from beam_case import FORCE, S_A, by_jacobi


def main():
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if not octave:
        raise SystemExit("octave is not installed (apt-get install octave); NumPy's first-order march stands for it")
    x, y, _ = by_jacobi(FORCE, S_A)
    script = pathlib.Path(__file__).with_name("first_order.m")
    run = subprocess.run(
        [octave, "--no-gui", "--quiet", "--norc", str(script)],
        env={**os.environ, "EXACT_X": repr(float(x)), "EXACT_Y": repr(float(y))},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False,
    )
    sys.stdout.write(run.stdout)
    if run.returncode:
        raise SystemExit(run.stderr.strip().splitlines()[-1] if run.stderr.strip() else "octave failed")


if __name__ == "__main__":
    main()
