"""A device that does not behave: rows of a log as lines with numbers and checksums, and a pseudo-terminal that can be unplugged."""

import fcntl
import os
import pty
import sys
import termios
import time
import tty

RATE = 300.0
SETUP = """map = "map.svg"
[[source]]
name = "robot"
serial = "port"
time = "stamps"
checksums = true
columns = ["seq16", "t_us", "x", "y", "theta", "moment"]
"""
# The paper's sensor beside odometry, for faults of the sensor alone.
FLUX = """map = "map.svg"
robot = "robot.toml"
[[source]]
name = "whisker"
serial = "port"
format = "serial"
[[source]]
name = "base"
serial = "port2"
columns = ["seq16", "t_us", "x", "y", "theta"]
"""


# A socket instead of the port, and a device without checksums.
SOCKET = SETUP.replace('serial = "port"', "{wire}")


def crc16(data):
    crc = 0xFFFF
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


class Port:
    """A pseudo-terminal under a name that stays when it is plugged in again."""

    def __init__(self, path):
        self.path, self.master = path, None
        self.plug()

    def plug(self):
        self.master, slave = pty.openpty()
        tty.setraw(slave, termios.TCSANOW)
        os.set_blocking(self.master, False)
        name = os.ttyname(slave)
        link = self.path.with_suffix(".new")
        link.symlink_to(name)
        link.rename(self.path)
        self.device, self.slave = name, slave

    def unplug(self, patience=2.0):
        # What nobody has read yet goes with the device; a busy machine reads late.
        end = time.monotonic() + patience
        while self.unread() and time.monotonic() < end:
            time.sleep(1e-3)
        self.path.unlink()
        os.close(self.slave)
        os.close(self.master)

    def unread(self):
        """Bytes that wait for a reader."""
        return int.from_bytes(fcntl.ioctl(self.slave, termios.FIONREAD, bytes(4)), sys.byteorder)

    def send(self, data, patience=1.0):
        """Writes; what is not taken within so long (s) is dropped, as a wire drops it. A device has no more patience than its buffer, but on a
        busy machine it is this process that sleeps, and then sends much at once."""
        end = time.monotonic() + patience
        while data:
            try:
                data = data[os.write(self.master, data) :]
            except BlockingIOError:
                if time.monotonic() >= end:
                    return
                time.sleep(1e-3)


class Rows:
    """The rows of a log, to and fro."""

    def __init__(self, path):
        lines = path.read_text().splitlines()
        columns = lines[0].split(",")
        wanted = [columns.index(name) for name in ("x", "y", "theta")] + [next(i for i, c in enumerate(columns) if c.endswith("moment"))]
        self.rows = [[line.split(",")[i] for i in wanted] for line in lines[1:] if line]

    def line(self, number, jump=0.0):
        period = 2 * (len(self.rows) - 1)
        place = number % period
        row = self.rows[place if place < len(self.rows) else period - place]
        stamp = int((number / RATE + jump) * 1e6) % (1 << 32)
        body = f"{number % 65536},{stamp},{','.join(row)}".encode()
        return body + f"*{crc16(body):04X}\r\n".encode()


def uart(data, sent, read):
    """Bytes sent at one baud rate and read at another: start bit, eight bits, stop bit."""
    bits = []
    for byte in data:
        bits += [0, *(byte >> k & 1 for k in range(8)), 1]
    out, at, step = bytearray(), 0.0, sent / read
    while at < len(bits):
        if bits[int(at)]:
            at += 0.5
            continue
        byte = 0
        for k in range(8):
            place = int(at + step * (1.5 + k))
            byte |= (bits[place] if place < len(bits) else 1) << k
        out.append(byte)
        at += 10 * step
    return bytes(out)


def feed(port, rows, seconds, spoil=lambda number, line: line, first=0):
    """Rows in real time; how many were sent."""
    began = time.monotonic()
    for number in range(int(seconds * RATE)):
        time.sleep(max(0.0, began + number / RATE - time.monotonic()))
        line = spoil(first + number, rows.line(first + number))
        if line:
            port.send(line)
    return int(seconds * RATE)
