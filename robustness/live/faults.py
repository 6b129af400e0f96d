#!/usr/bin/env python3
"""Faults of the live path, one run of `vibrissa live` each: what was done, what was lost, the line that the user sees.

Usage: robustness/live/faults.py VIBRISSA [--short] [--write docs/live-faults.md]

A feeder plays the log of `vibrissa demo` to and fro through a pseudo-terminal at 300 rows a second, with numbers and checksums, and does
something to it. Every run must go on, say what is wrong, count what is missing, and leave a recording that plays again to the same
bytes. Exit 1 where one does not. --short takes fewer kills and cuts (for each change), --write puts the table into a page.
"""

import argparse
import os
import random
import re
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from feeder import FLUX, RATE, SETUP, SOCKET, Port, Rows, feed, uart
from live_run import Run


class Faults:
    """Each returns what was done, what was lost, the line that was seen."""

    def __init__(self, program, world, folder, short):
        self.program, self.world, self.folder, self.short = program, world, folder, short
        self.rows = Rows(world / "log.csv")

    def run(self, name, setup=SETUP, **how):
        return Run(self.program, self.folder / name, self.world, setup, **how)

    def port(self, run, name="port"):
        return Port(run.folder / name)

    def kills(self, name, dice):
        """Kills some runs; the most that one lost (s)."""
        worst, kills = 0.0, 3 if self.short else 20
        for kill in range(kills):
            run = self.run(f"{name}{kill}")
            port = self.port(run)
            run.start("--json")
            lines = []
            reader = threading.Thread(target=lambda: lines.extend(run.process.stdout), daemon=True)
            reader.start()
            feed(port, self.rows, 1.0 + dice.random())
            run.process.kill()
            run.process.wait()
            reader.join()
            same, of = run.again()
            assert same == of, f"{same} of {of} estimates are the same"
            # What was told and is not in the recording, at twenty estimates a second.
            worst = max(worst, (len(lines) - of) / 20.0)
        assert worst <= 0.5, f"{worst} s lost"
        return kills, f"at most {worst:.2f} s of estimates; what is recorded plays again to the same bytes", "(none: it is dead)"

    def killed(self):
        kills, lost, seen = self.kills("killed", random.Random(3))
        return f"`kill -9` at a random moment, {kills} times", lost, seen

    def killed_busy(self):
        # Twice as many programs that compute as there are processors, and one that writes and synchronises without end.
        spin = "while True: pass"
        write = "import os\nf = open('load', 'wb')\nwhile True:\n f.seek(0)\n f.write(bytes(64 << 20))\n f.flush()\n os.fsync(f.fileno())"
        busy = [subprocess.Popen([sys.executable, "-c", spin]) for _ in range(2 * os.cpu_count())]
        busy.append(subprocess.Popen([sys.executable, "-c", write], cwd=self.folder))
        try:
            kills, lost, seen = self.kills("busy", random.Random(4))
        finally:
            for program in busy:
                program.kill()
                program.wait()
            (self.folder / "load").unlink(missing_ok=True)
        return f"the same, {kills} times, while {len(busy) - 1} programs compute on {os.cpu_count()} processors and one writes and synchronises 64 MB again and again", lost, seen

    def full_disk(self):
        run = self.run("full", restore_signals=False, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, resource.RLIM_INFINITY)))
        port = self.port(run)
        run.start()
        sent = feed(port, self.rows, 3.0)
        subprocess.run(["prlimit", f"--pid={run.process.pid}", "--fsize=unlimited:unlimited"], check=True)
        sent += feed(port, self.rows, 2.5, first=sent)
        time.sleep(0.5)
        run.stop()
        seen = run.said("recording:", "waits in memory")
        run.said("takes it again")
        counts = run.account()
        assert counts["frames"] >= sent - 5, counts
        assert "dropped" not in run.out, run.out
        return "the disk is full for two seconds (limit of 60 kB on the file)", f"nothing; {run.same()}", seen

    def slow_disk(self):
        if not shutil.which("strace"):
            return "each synchronisation takes a second", "NOT RUN here (strace is missing); `tests/recording.rs` has a slow disk of its own", ""
        wrap = ["strace", "-f", "-qq", "-o", "/dev/null", "-e", "trace=fdatasync,fsync", "-e", "inject=fdatasync,fsync:delay_exit=1000000"]
        run = self.run("slow", wrap=wrap)
        port = self.port(run)
        run.start()
        sent = feed(port, self.rows, 4.0)
        time.sleep(0.3)
        child = subprocess.run(["pgrep", "-P", str(run.process.pid)], capture_output=True, text=True, check=True).stdout.split()[0]
        os.kill(int(child), signal.SIGINT)
        run.out, _ = run.process.stdout.read(), run.process.wait(timeout=60)
        counts = run.account()
        assert counts["frames"] >= sent - 5, counts
        return "each synchronisation with the disk takes a second", f"nothing; {run.same()}", "(none: it waits in memory)"

    def unplugged(self):
        run = self.run("unplugged")
        port = self.port(run)
        run.start()
        sent = feed(port, self.rows, 1.5)
        port.unplug()
        time.sleep(1.0)
        port.plug()
        run.opened(2)
        sent += feed(port, self.rows, 1.5, first=sent)
        time.sleep(0.3)
        run.stop()
        counts = run.account()
        assert counts["frames"] >= sent - 5 and counts["gone"] >= 1, counts
        return "the device is unplugged for a second", f"what the device sent meanwhile; {run.same()}", next(line.strip() for line in run.lines if line.startswith("robot:") and "open" not in line.split()[1:2])

    def clock_jumps(self):
        run = self.run("clock")
        port = self.port(run)
        run.start()
        jumps = {300: 100.0, 600: -50.0, 900: 3000.0}
        at = lambda number: sum(jump for row, jump in jumps.items() if number >= row)  # noqa: E731
        sent = feed(port, self.rows, 4.0, lambda number, _: self.rows.line(number, at(number)))
        time.sleep(0.3)
        run.stop()
        counts = run.account()
        assert counts["frames"] >= sent - 5 and counts["used"] + counts["merged"] >= 0.6 * sent, counts
        lost = sent - counts["used"] - counts["merged"]
        return "the device's clock jumps by 100, -50 and 3000 s", f"{lost} of {sent} rows, at the jumps; {run.same()}", run.said("clock or count jumped")

    def cut(self):
        run = self.run("cut")
        port = self.port(run)
        run.start()
        dice, cuts = random.Random(1), 1000 if self.short else 10_000
        lines = int(1.25 * cuts)
        data = bytearray(b"".join(self.rows.line(number) for number in range(lines)))
        # Runs of one to four bytes are taken away, from behind.
        places = sorted(dice.sample(range(8, len(data) - 8), cuts), reverse=True)
        for place in places:
            del data[place : place + dice.randint(1, 4)]
        # A line that lost its end alone is whole.
        whole = {self.rows.line(number).strip() for number in range(lines)}
        intact = sum(line in whole for line in re.split(rb"[\r\n]+", bytes(data)))
        begun = time.monotonic()
        for start in range(0, len(data), 512):
            # As fast as a line of 1 Mbaud.
            time.sleep(max(0.0, begun + start / 1e5 - time.monotonic()))
            port.send(bytes(data[start : start + 512]), patience=10.0)
        time.sleep(0.5)
        run.stop()
        counts = run.account()
        # The piece of line in front of the first whole one, and the last one without an end, are neither.
        assert intact - 2 <= counts["frames"] <= intact, (counts, intact)
        return (
            f"{cuts:,} cuts: one to four bytes are missing at random places of {lines:,} lines with checksums",
            f"{lines - counts['frames']:,} lines that were hit ({counts.get('damaged', 0):,} damaged, {counts.get('lost', 0):,} lost by their numbers); "
            f"{intact:,} are whole and {counts['frames']:,} were read, none invented; {run.same()}",
            run.said("robot:", "check"),
        )

    def wrong_baud(self):
        run = self.run("baud")
        port = self.port(run)
        run.start()
        sent = feed(port, self.rows, 3.0, lambda _, line: uart(line, 115200, 57600))
        time.sleep(0.5)
        run.stop()
        assert run.account()["frames"] == 0, run.account()
        return "the device sends at 115200 baud, 57600 is set", f"all {sent} lines: nothing is read, nothing is invented", run.said("check baud rate and format")

    def flux(self, name, line, seconds=3.0):
        run = self.run(name, FLUX)
        whisker, base = self.port(run), self.port(run, "port2")
        run.start(opens=2)

        def send(number, _):
            whisker.send(line(number))
            if number % 6 == 0:
                x, y, theta, _ = self.rows.rows[min(number, len(self.rows.rows) - 1)]
                base.send(f"{number // 6},{int(number / RATE * 1e6)},{x},{y},{theta}\r\n".encode())

        sent = feed(whisker, self.rows, seconds, send)
        time.sleep(0.5)
        run.stop()
        return run, sent

    def zeros(self):
        run, sent = self.flux("zeros", lambda _: b"0.00,0.00,0.00\r\n")
        counts = run.account("whisker")
        assert counts["frames"] >= sent - 5, counts
        return "the sensor sends only zeros", f"{counts.get('uncalibrated', 0)} of {sent} frames are beyond the calibration and left out", run.said("all zero")

    def two_on_one(self):
        run = self.run("two")
        port = self.port(run)
        run.start()
        dice = random.Random(2)

        def both(number, line):
            # Another device with numbers of its own: its bytes come between ours.
            other = self.rows.line(number + 7000)
            at, to = dice.randrange(len(line)), dice.randrange(len(other))
            return line[:at] + other[:to] + line[at:] + other[to:]

        sent = feed(port, self.rows, 3.0, both)
        time.sleep(0.5)
        run.stop()
        counts = run.account()
        seen = next((line.strip() for line in run.lines if line.startswith("robot:") and "open" not in line), "")
        assert seen, run.lines[-5:]
        return "two devices on one port", f"{counts.get('damaged', 0)} mixed lines, damaged by their checksums; {counts['frames']} of {2 * sent} were whole", seen

    def no_permission(self):
        how = {"user": 65534, "group": 65534, "extra_groups": []} if os.getuid() == 0 else {}
        run = self.run("permission", **how)
        port = self.port(run)
        os.chmod(port.device, 0)
        if how:
            os.chown(run.folder, 65534, 65534)
        run.start(opens=0)
        time.sleep(1.0)
        os.chmod(port.device, 0o666)
        run.opened(1)
        sent = feed(port, self.rows, 1.5)
        time.sleep(0.3)
        run.stop()
        counts = run.account()
        assert counts["frames"] >= sent - 5, counts
        return "no permission on the port; it is given a second later", f"what was sent before; then {counts['frames']} of {sent} frames", run.said("ermission")

    def noise(self):
        run = self.run("noise")
        port = self.port(run)
        run.start()
        dice = random.Random(5)
        # Random bytes, line ends among them, after every third line; they spoil the line that follows them, too.
        spoil = lambda number, line: line + dice.randbytes(dice.randrange(1, 40)) if number % 3 == 0 else line  # noqa: E731
        sent = feed(port, self.rows, 3.0, spoil)
        time.sleep(0.3)
        run.stop()
        counts = run.account()
        assert sent // 3 - 2 <= counts["frames"] <= sent, counts
        return (
            "1 to 40 random bytes after every third line",
            f"{sent - counts['frames']} of {sent} lines, those that the noise runs into; {counts.get('damaged', 0)} damaged, none invented; {run.same()}",
            run.said("robot:", "are missing"),
        )

    def halves(self):
        run = self.run("halves")
        port = self.port(run)
        run.start()

        def both(_, line):
            # The second half comes later, and after every tenth line never.
            port.send(line[: len(line) // 2])
            time.sleep(1e-3)
            return line[len(line) // 2 :] if both.count % 10 else b""

        def counted(number, line):
            both.count += 1
            return both(number, line)

        both.count = 0
        sent = feed(port, self.rows, 3.0, counted)
        time.sleep(0.3)
        run.stop()
        counts = run.account()
        assert 0.8 * sent - 3 <= counts["frames"] <= 0.8 * sent + 3, counts
        return (
            "every line comes in two halves; every tenth one has no second half",
            f"the half lines and those that they run into: {counts['frames']} of {sent} were read, {counts.get('damaged', 0)} damaged; {run.same()}",
            run.said("robot:", "are missing"),
        )

    def stream(self, name, family, address, wire):
        run = self.run(name, SOCKET.format(wire=wire))
        listening = socket.socket(family)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind(address if address else str(run.folder / "socket"))
        listening.listen()
        if address:
            setup = run.folder / "live.toml"
            setup.write_text(setup.read_text().replace("PORT", str(listening.getsockname()[1])))
        run.start(opens=0)
        sent = 0
        for part in range(2):
            link, _ = listening.accept()
            run.opened(part + 1)

            class Link:
                send = staticmethod(link.sendall)

            sent += feed(Link, self.rows, 1.5, first=sent)
            time.sleep(0.3)
            link.close()
        listening.close()
        time.sleep(1.0)
        run.stop()
        counts = run.account()
        assert counts["frames"] == sent and counts["gone"] >= 2, counts
        return counts, sent, run

    def tcp(self):
        counts, sent, run = self.stream("tcp", socket.AF_INET, ("127.0.0.1", 0), 'tcp = "127.0.0.1:PORT"')
        return "a TCP server closes the connection, takes a new one, then ends", f"nothing: {counts['frames']} of {sent} frames; {run.same()}", run.said("robot:", "refused")

    def unix(self):
        counts, sent, run = self.stream("unix", socket.AF_UNIX, None, 'unix = "socket"')
        return "the same of a Unix socket", f"nothing: {counts['frames']} of {sent} frames; {run.same()}", run.said("robot:", "refused")

    def udp(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        run = self.run("udp", SOCKET.format(wire=f'udp = "127.0.0.1:{port}"'))
        run.start()
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        dice, held, lost, again, late = random.Random(7), [], 0, 0, 0

        class Link:
            @staticmethod
            def send(line):
                nonlocal lost, again, late
                what = dice.random()
                if what < 0.05:
                    lost += 1
                    return
                if what < 0.1:
                    again += 1
                    sender.sendto(line, ("127.0.0.1", port))
                elif what < 0.15 and not held:
                    late += 1
                    held.append(line)
                    return
                sender.sendto(line, ("127.0.0.1", port))
                while held:
                    sender.sendto(held.pop(), ("127.0.0.1", port))

        sent = feed(Link, self.rows, 3.0)
        time.sleep(0.3)
        run.stop()
        counts = run.account()
        assert counts["used"] + counts["merged"] == sent - lost - late, (counts, sent, lost, again, late)
        assert (counts["lost"], counts["repeated"], counts["late"]) == (lost, again, late), (counts, sent, lost, again, late)
        return (
            "UDP: of the datagrams 5 % are lost, 5 % come twice, 5 % behind their follower",
            f"{lost} of {sent} were not sent and {late} came late: told as {counts['lost']} lost, {counts['late']} late, {counts['repeated']} repeated; {run.same()}",
            run.said("robot:", "are missing"),
        )

    def silent(self):
        run = self.run("silent")
        port = self.port(run)
        run.start()
        sent = feed(port, self.rows, 1.0)
        time.sleep(3.5)
        sent += feed(port, self.rows, 1.0, first=sent)
        time.sleep(0.3)
        run.stop()
        counts = run.account()
        assert counts["frames"] >= sent - 5, counts
        return "the device stops for three seconds, with its port open", f"nothing: {counts['frames']} of {sent} frames; {run.same()}", run.said("robot:", "nothing has come")

    def nothing_there(self):
        run = self.run("nothing")
        run.start(opens=0)
        time.sleep(1.0)
        port = self.port(run)
        run.opened(1)
        sent = feed(port, self.rows, 1.0)
        time.sleep(0.3)
        run.stop()
        counts = run.account()
        assert counts["frames"] >= sent - 5, counts
        return "no port of that name; it comes a second later", f"nothing: {counts['frames']} of {sent} frames", run.said("robot:")


ALL = ["killed", "killed_busy", "full_disk", "slow_disk", "unplugged", "clock_jumps", "cut", "noise", "halves", "wrong_baud", "zeros", "two_on_one"]
ALL += ["silent", "no_permission", "nothing_there", "tcp", "unix", "udp"]

# What keeps the machine busy, so that other faults would be seen later.
ALONE = ["killed_busy"]


def table(found):
    cell = lambda text: re.sub(r"/tmp/\S*?/(port\d?|live|socket)", r"\1", re.sub(r"127.0.0.1:\d+", "HOST:PORT", text)).replace("|", "\\|").replace("<", "&lt;")  # noqa: E731
    lines = ["| fault | what was lost | the line that is seen |", "| --- | --- | --- |"]
    for done, lost, seen in found:
        quoted = cell(seen).replace("`", "'")
        said = f"`{quoted}`" if seen and not seen.startswith("(") else cell(seen)
        lines.append(f"| {cell(done)} | {cell(lost)} | {said} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--write", type=Path)
    parser.add_argument("--only", help="one of " + ", ".join(ALL))
    args = parser.parse_args()
    program = args.program.resolve()
    with tempfile.TemporaryDirectory(prefix="vibrissa-faults-") as name:
        folder = Path(name)
        folder.chmod(0o755)
        world = folder / "world"
        subprocess.run([program, "demo", "--out", world], check=True, capture_output=True)
        (world / "robot.toml").write_text('[[whisker]]\nname = "w0"\ncalibration = "cal.json"\n')
        shutil.copy(Path(__file__).resolve().parent / "cal.json", world / "cal.json")
        faults = Faults(program, world, folder, args.short)
        names = [args.only] if args.only else ALL
        # Each run has little to do; three at once, but for one that keeps the machine busy.
        with ThreadPoolExecutor(3) as pool:
            running = {name: pool.submit(getattr(faults, name)) for name in names if name not in ALONE}
        with ThreadPoolExecutor(1) as pool:
            running |= {name: pool.submit(getattr(faults, name)) for name in names if name in ALONE}
        running = {name: running[name] for name in names}
        found, failed = [], []
        for name, future in running.items():
            try:
                found.append(future.result())
            except (AssertionError, subprocess.SubprocessError, OSError, KeyError) as error:
                failed.append(f"{name}: {error}")
        print(table(found))
        if failed:
            sys.exit("FAILED\n" + "\n".join(failed))
    if args.write:
        text = args.write.read_text()
        begin, end = "<!-- faults: written by robustness/live/faults.py -->\n", "\n<!-- end of faults -->"
        head, rest = text.split(begin)
        args.write.write_text(head + begin + table(found) + end + rest.split(end)[1])
        print(f"\nwritten: {args.write}")


main()
