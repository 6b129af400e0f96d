"""Opens a page in headless Chromium, checks it, and takes pictures of it.

Usage: browser.py REPORT.html FOLDER

At 1280 and at 390 px: no complaint on the console, nothing loaded from elsewhere, no broken image, no empty picture, nothing
wider than the window but what scrolls by itself, every number of the page in the file of numbers beside it. The pictures go
into FOLDER. Chromium is talked to over a pipe (its DevTools protocol), so that Python's own library is enough.
"""

import base64
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

WIDTHS = {"desk": 1280, "phone": 390}
TALLEST = 6000  # one picture (px)

CHECKS = """
(() => {
  const wide = [...document.querySelectorAll('body *')].filter(e => {
    if (e.closest('svg') && e.tagName !== 'svg') return false;
    if (e.closest('.scroll') && !e.classList.contains('scroll')) return false;
    const box = e.getBoundingClientRect();
    return box.width > 0 && box.right > innerWidth + 1;
  }).map(e => e.tagName + '.' + e.className);
  const pictures = [...document.querySelectorAll('svg')];
  const small = pictures.filter(p => {
    const box = p.getBoundingClientRect();
    return box.width < 200 || box.height < 100 || p.querySelectorAll('path, line, circle, rect').length < 5;
  }).length;
  const scale = pictures.map(p => p.getBoundingClientRect().width / p.viewBox.baseVal.width);
  const outside = pictures.flatMap(p => [...p.querySelectorAll('text')].filter(t => {
    const box = t.getBBox(), page = p.viewBox.baseVal;
    return !t.closest('g') && (box.x < -0.5 || box.y < -0.5 || box.x + box.width > page.width + 0.5 || box.y + box.height > page.height + 0.5);
  }).map(t => t.textContent));
  const overlap = pictures.flatMap(p => {
    const texts = [...p.querySelectorAll('text')].map(t => [t.textContent, t.getBBox()]);
    const hits = [];
    texts.forEach(([a, s], i) => texts.slice(i + 1).forEach(([b, t]) => {
      const x = Math.min(s.x + s.width, t.x + t.width) - Math.max(s.x, t.x);
      const y = Math.min(s.y + s.height, t.y + t.height) - Math.max(s.y, t.y);
      if (x > 1 && y > 4) hits.push(a + ' / ' + b);
    }));
    return hits;
  });
  return JSON.stringify({
    title: document.title,
    wide: [...new Set(wide)],
    pictures: pictures.length,
    small,
    outside,
    overlap,
    least_scale: Math.min(...scale),
    broken: [...document.images].filter(i => !i.complete || i.naturalWidth === 0).length,
    smallest_text: Math.min(...[...document.querySelectorAll('p, td, th, dd, dt, li')].map(e => parseFloat(getComputedStyle(e).fontSize))),
    numbers: [...document.querySelectorAll('[data-key]')].map(e => [e.dataset.key, e.textContent]),
    height: document.documentElement.scrollHeight,
  });
})()
"""


class Chromium:
    """A headless browser at the other end of two pipes."""

    def __init__(self, program, profile):
        to_read, self.write_end = os.pipe()
        self.read_end, to_write = os.pipe()
        # The browser reads commands from descriptor 3 and writes answers to 4.
        self.process = subprocess.Popen(
            ["bash", "-c", f'exec "$0" "$@" 3<&{to_read} 4>&{to_write}', program, "--headless", "--no-sandbox", "--disable-gpu",
             "--hide-scrollbars", "--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"],
            pass_fds=(to_read, to_write), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(to_write)
        self.buffer, self.count, self.events, self.session = b"", 0, [], None

    def receive(self):
        while b"\0" not in self.buffer:
            piece = os.read(self.read_end, 1 << 20)
            if not piece:
                sys.exit("the browser closed its end")
            self.buffer += piece
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **parameters):
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.write_end, data):]
        while True:
            answer = self.receive()
            if answer.get("id") == self.count:
                if "error" in answer:
                    sys.exit(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def wait_for(self, method):
        while not any(event.get("method") == method for event in self.events):
            self.events.append(self.receive())

    def close(self):
        self.session = None
        self.call("Browser.close")
        self.process.wait(timeout=20)


def complaints(events):
    """What the console, the log and the network say against the page."""
    found = []
    for event in events:
        method, parameters = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            found.append("exception: " + json.dumps(parameters["exceptionDetails"])[:300])
        elif method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            found.append("console: " + json.dumps(parameters["args"])[:300])
        elif method == "Log.entryAdded" and parameters["entry"]["level"] in ("error", "warning"):
            found.append("log: " + parameters["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            url = parameters["request"]["url"]
            if not url.startswith(("data:", "file:///")) or (url.startswith("file:") and not url.endswith("report.html")):
                found.append("asks for " + url)
    return found


def pictures(browser, folder, name, width, height, scheme):
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    for index, top in enumerate(range(0, height, TALLEST)):
        clip = {"x": 0, "y": top, "width": width, "height": min(TALLEST, height - top), "scale": 1}
        shot = browser.call("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)
        (folder / f"{name}-{scheme}-{index + 1}.png").write_bytes(base64.b64decode(shot["data"]))


def visit(browser, page, name, width, folder):
    target = browser.call("Target.createTarget", url="about:blank")["targetId"]
    browser.session, session = None, browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
    browser.session, browser.events = session, []
    for domain in ("Page", "Runtime", "Log", "Network"):
        browser.call(f"{domain}.enable")
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 600)
    browser.call("Page.navigate", url=page.as_uri())
    browser.wait_for("Page.loadEventFired")
    answer = browser.call("Runtime.evaluate", expression=CHECKS)["result"]
    seen = json.loads(answer["value"])
    for scheme in ("light", "dark"):
        pictures(browser, folder, name, width, seen["height"], scheme)
    seen["complaints"] = complaints(browser.events)
    browser.session = None
    browser.call("Target.closeTarget", targetId=target)
    return seen


def faults(seen, numbers):
    wrong = list(seen["complaints"])
    for key in ("wide", "outside", "overlap"):
        wrong += [f"{key}: {what}" for what in seen[key]]
    for key in ("small", "broken"):
        if seen[key]:
            wrong.append(f"{key} pictures: {seen[key]}")
    if seen["pictures"] == 0:
        wrong.append("no pictures")
    if seen["least_scale"] < 0.75:
        wrong.append(f"a picture is shrunk to {seen['least_scale']:.2f}")
    if seen["smallest_text"] < 12:
        wrong.append(f"text of {seen['smallest_text']} px")
    if not seen["numbers"]:
        wrong.append("no numbers")
    for key, shown in seen["numbers"]:
        if numbers.get(key, {}).get("shown") != shown:
            wrong.append(f"number {key}: {shown} on the page, {numbers.get(key)} in the file")
    return wrong


def main():
    page, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if program is None:
        sys.exit("no Chromium here: apt-get install chromium")
    numbers = json.loads(page.with_name("reproduce.json").read_text())["numbers"]
    bad = 0
    with tempfile.TemporaryDirectory() as profile:
        browser = Chromium(program, profile)
        for name, width in WIDTHS.items():
            seen = visit(browser, page, name, width, folder)
            wrong = faults(seen, numbers)
            bad += len(wrong)
            print(f"{name}, {width} px: {seen['pictures']} pictures, {len(seen['numbers'])} numbers, {seen['height']} px tall, "
                  f"pictures at {seen['least_scale']:.2f} or more, text of {seen['smallest_text']:.1f} px or more, {len(wrong)} faults")
            for what in wrong[:40]:
                print("  " + what)
        browser.close()
    sys.exit(1 if bad else 0)


main()
