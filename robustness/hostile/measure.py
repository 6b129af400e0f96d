#!/usr/bin/env python3
"""Feeds hostile files to the command `vibrissa` and measures each process: its work, peak memory, length and cleanness of its words.

    robustness/hostile/measure.py target/release/vibrissa [--only WORD] [--keep DIR] [--markdown FILE]

The budgets that must hold for any input file below 100 MB: 10 s, 1 GB, 4 kB of words without control characters.
The exit code is 1 where one does not hold. Needs Python 3.9 alone; seconds are those of the processor,
which a busy machine does not change, and peak memory is the kernel's (wait4).
"""

import argparse
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import files

#: Most work for a file below 100 MB (s).
SECONDS = 10.0
#: Most memory (MB).
MEMORY = 1000.0
#: Most words on standard error (bytes).
WORDS = 4096
#: A process is ended after this time (s),
GIVEN_UP = 300.0
#: and fails to allocate beyond this (bytes), to spare the machine.
ADDRESS_SPACE = 8 << 30


def measured(command, folder):
    """Exit code, seconds, peak memory (MB) and standard error of a process."""
    import resource

    def limits():
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    with open(folder / "stderr", "w+b") as told:
        child = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=told, preexec_fn=limits, cwd=folder
        )
        timer = threading.Timer(GIVEN_UP, lambda: os.kill(child.pid, signal.SIGKILL))
        timer.start()
        _, status, usage = os.wait4(child.pid, 0)
        timer.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        seconds = usage.ru_utime + usage.ru_stime
        size = told.tell() or os.path.getsize(told.name)
        told.seek(0)
        words = told.read(100_000)
    return child.returncode, seconds, usage.ru_maxrss / 1024, size, words


def special(folder):
    """Files that are none: a device without end, a pipe without writer, a folder, a socket."""
    os.mkfifo(folder / "fifo")
    (folder / "folder").mkdir()
    server = socket.socket(socket.AF_UNIX)
    server.bind(str(folder / "socket"))
    found = []
    for name, target in [("zero", "/dev/zero"), ("fifo", "fifo"), ("folder", "folder"), ("socket", "socket")]:
        for extension in ["svg", "geojson", "dxf", "yaml", "mcap", "csv", "toml", "tum", "json", "txt"]:
            link = folder / f"{name}.{extension}"
            link.symlink_to(target)
            found.append(link.name)
        (folder / f"{name}-image.yaml").write_text(files.YAML.format(target))
        found.append(f"{name}-image.yaml")
    return found, server


def calls(folder, binary):
    """Each hostile file: its name, what it is, what makes it, and the command that reads it."""
    log, sound = "sound/log.csv", "sound/map.svg"

    def map_call(name):
        return ["localize", "missing.csv", "--map", name]

    def robot_call(name):
        return ["contact", "sound/eight.csv" if name == "eight.toml" else log, "--robot", name]

    def beam_call(name):
        return ["beam", "point", "--x", "0.03", "--y", "0.01", "--robot", name]

    def log_call(name):
        return ["localize", name, "--map", sound, "--method", "deterministic"]

    def truth_call(name):
        return ["localize", log, "--map", sound, "--truth", name]

    def foreign_call(name):
        kinds = {"rostopic": "rostopic", "foreign": "csv", "txt": "serial"}
        return ["contact", name, "--format", kinds.get(name.rsplit(".", 1)[1], "csv")]

    def calibration_call(name):
        return ["contact", log, "--taps", "--calibration", name]

    def scenario_call(name):
        return ["simulate", name]

    def batch_call(name):
        return ["beam", "force", "--batch", name]

    groups = [
        (files.MAPS, map_call),
        (files.ROBOTS, robot_call),
        (files.BEAMS, beam_call),
        (files.LOGS, log_call),
        (files.TRUTHS, truth_call),
        (files.FOREIGN, foreign_call),
        (files.CALIBRATIONS, calibration_call),
        (files.SCENARIOS, scenario_call),
        (files.BATCHES, batch_call),
    ]
    for group, call in groups:
        for name, (what, make) in group.items():
            yield name, what, make, call(name)
    of_extension = {
        "svg": map_call, "geojson": map_call, "dxf": map_call, "yaml": map_call, "mcap": log_call, "csv": log_call,
        "toml": robot_call, "tum": truth_call, "json": calibration_call, "txt": foreign_call,
    }
    for name in special(folder)[0]:
        yield name, f"{name.split('.')[0]} for a file", None, of_extension[name.rsplit(".", 1)[1]](name)


def made(folder, name, make):
    """Writes the file, and the image of a YAML file beside it; its size (MB)."""
    if make is None:
        return 0.0
    path = folder / name
    if isinstance(make, tuple):
        image = folder / f"{path.stem}-image.{make[1]}"
        image.write_bytes(make[0]())
        path.write_text(files.YAML.format(image.name))
        return image.stat().st_size / files.MB
    path.write_bytes(make())
    return path.stat().st_size / files.MB


def eight_readings(folder):
    """The sound log with its moment for eight whiskers."""
    head, *rows = (folder / "log.csv").read_text().splitlines()
    k = head.split(",").index("moment")
    names = ",".join(f"w{i}.moment" for i in range(8))
    lines = [head.replace("moment", names)]
    for row in rows:
        cells = row.split(",")
        lines.append(",".join(cells[:k] + [cells[k]] * 8 + cells[k + 1:]))
    (folder / "eight.csv").write_text("\n".join(lines) + "\n")


def first_words(words, code):
    lines = words.decode(errors="replace").splitlines()
    told = next((line for line in lines if line.startswith("error")), lines[0] if lines else "")
    if code is not None and code < 0:
        told = f"killed by signal {-code}. {told}"
    return "".join(c if c.isprintable() else "?" for c in told)[:150].replace("|", "/")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary", type=Path)
    parser.add_argument("--only", default="", help="files whose name holds this word")
    parser.add_argument("--keep", type=Path, help="keep the files there")
    parser.add_argument("--markdown", type=Path, help="write the table there")
    args = parser.parse_args()
    binary = str(args.binary.resolve())
    temporary = None if args.keep else tempfile.TemporaryDirectory(prefix="hostile-")
    folder = args.keep or Path(temporary.name)
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([binary, "demo", "--out", str(folder / "sound")], check=True, stdout=subprocess.DEVNULL)
    eight_readings(folder / "sound")
    table = ["| file | MB | what | s | MB memory | exit | bytes of words | words |", "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    print("\n".join(table), flush=True)
    beyond = 0
    for name, what, make, call in calls(folder, binary):
        if args.only not in name:
            continue
        size = made(folder, name, make)
        code, seconds, memory, length, words = measured([binary, *call], folder)
        steered = any(byte < 32 and byte not in (9, 10) for byte in words)
        fault = code not in (0, 1, 2) or seconds > SECONDS or memory > MEMORY or length > WORDS or steered
        beyond += fault
        row = f"| {'**' + name + '**' if fault else name} | {size:.1f} | {what} | {seconds:.1f} | {memory:.0f} | {code} | {length} | {first_words(words, code)} |"
        table.append(row)
        print(row, flush=True)
        if make is not None and not args.keep:
            (folder / name).unlink()
    print(f"{len(table) - 2} files, {beyond} beyond a budget", flush=True)
    if args.markdown:
        args.markdown.write_text("\n".join(table) + "\n")
    return 1 if beyond else 0


if __name__ == "__main__":
    sys.exit(main())
