"""One run of `vibrissa live` on a folder of its own: what it says, what it counts, and whether its recording plays again."""

import re
import shutil
import signal
import subprocess
import threading
import time

from feeder import SETUP


class Run:
    """One run of the command on a folder of its own."""

    def __init__(self, program, folder, world, setup=SETUP, **how):
        self.program, self.folder = program, folder
        folder.mkdir(parents=True)
        for name in ("map.svg", "robot.toml", "cal.json"):
            if (world / name).exists():
                shutil.copy(world / name, folder / name)
        (folder / "live.toml").write_text(setup)
        self.how = how
        self.began = time.monotonic()

    def start(self, *more, opens=1):
        self.lines = []
        self.process = subprocess.Popen(
            [*self.how.get("wrap", []), self.program, "live", self.folder / "live.toml", "--out", self.folder / "live", *more],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            **{key: value for key, value in self.how.items() if key != "wrap"},
        )
        self.reader = threading.Thread(target=lambda: self.lines.extend(self.process.stderr), daemon=True)
        self.reader.start()
        self.opened(opens)

    def opened(self, count):
        """Waits until ports were opened so many times."""
        end = time.monotonic() + 20.0
        while sum(line.rstrip().endswith(": open") for line in self.lines) < count:
            assert time.monotonic() < end, f"no port was opened: {self.lines[-5:]}"
            time.sleep(0.05)

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        try:
            self.out, _ = self.process.stdout.read(), self.process.wait(timeout=30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise AssertionError("it did not end") from None
        self.reader.join()

    def account(self, source="robot"):
        """Counts of a source by the account at the end."""
        line = next((line for line in self.out.splitlines() if line.strip().startswith(source + ":")), "")
        counts = {word: int(number) for number, word in re.findall(r"(\d+) ([a-z]+)", line)}
        rows = re.search(r"rows: (\d+) used, (\d+) merged", self.out)
        counts["used"], counts["merged"] = (int(rows[1]), int(rows[2])) if rows else (0, 0)
        return counts

    def said(self, *words):
        found = next((line.strip() for line in self.lines if all(word in line for word in words)), None)
        assert found, f"nobody said {words}: {[line for line in self.lines if '|' not in line][-8:]}"
        return found

    def again(self):
        """Plays the recording again; the estimates that are the same, of how many."""
        played = subprocess.run([self.program, "live", "--replay", self.folder / "live"], capture_output=True, text=True, check=False)
        found = re.search(r"estimates: (\d+) of (\d+) the same", played.stdout)
        assert found, f"it does not play again: {played.stdout}{played.stderr}"
        return int(found[1]), int(found[2])

    def same(self):
        same, of = self.again()
        assert same == of and of > 0, f"{same} of {of} estimates are the same"
        return f"{of} estimates the same to the byte"
