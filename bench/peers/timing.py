"""What the peers' scripts share: processor time in batches, and the lines that `bench/report.py` reads."""

import statistics
import time


def batches(call, count=7, least=0.05):
    """Seconds of processor time a call: one number for each of `count` batches of at least `least` seconds."""
    repeat = 1
    while True:
        begin = time.process_time()
        for _ in range(repeat):
            call()
        if time.process_time() - begin > least:
            break
        repeat *= 2
    times = []
    for _ in range(count):
        begin = time.process_time()
        for _ in range(repeat):
            call()
        times.append((time.process_time() - begin) / repeat)
    return times


def once(call):
    """The answer of one call and its processor time."""
    begin = time.process_time()
    answer = call()
    return answer, time.process_time() - begin


def row(table, name, times, remark=""):
    """A line of a table: median, least and largest seconds."""
    print("row", table, name, *(f"{t:.6g}" for t in (statistics.median(times), min(times), max(times))), remark, sep="\t", flush=True)


def point(picture, series, x, seconds):
    """A point of a picture of scaling."""
    print("point", picture, series, x, f"{seconds:.6g}", sep="\t", flush=True)
