"""Files that are made to cost: each a name, what it attacks, and the bytes; below 100 MB each."""

import math
import struct
import zlib

MB = 1_000_000
#: Size of the files that attack by size (bytes),
LARGE = 95 * MB
#: of maps, as large as they may be,
MAP = 63 * MB
#: of robots and of calibrations.
TOML, JSON = MB, 4 * MB


def repeated(piece, size=LARGE):
    """As many whole pieces as fit into `size` bytes."""
    piece = piece.encode() if isinstance(piece, str) else piece
    return piece * (size // len(piece))


# Maps in SVG.

def svg(inner, head="", front=""):
    return f'<?xml version="1.0"?>{front}<svg xmlns="http://www.w3.org/2000/svg"{head}>{inner}</svg>'.encode()


ARENA = '<rect id="arena" width="400" height="300"/>'


def entity_in_text():
    return svg(ARENA + "<text>" + "&a;" * 4000 + "</text>", front=f'<!DOCTYPE svg [<!ENTITY a "{"x" * MB}">]>')


def entity_in_attribute():
    uses = "".join(f'<g id="g{i}" style="{"&a;" * 20}"/>' for i in range(200))
    return svg(ARENA + uses, front=f'<!DOCTYPE svg [<!ENTITY a "{"x" * MB}">]>')


def entities_in_entities():
    rows = ['<!ENTITY a0 "xxxxxxxxxx">']
    rows += [f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 9)]
    return svg(ARENA + "<text>&a8;</text>", front=f"<!DOCTYPE svg [{''.join(rows)}]>")


def far_beziers():
    way = "".join(f"C {9e7 - i} {9e7} {-9e7} {9e7 - i} {i} {i}" for i in range(1, 200))
    return svg(f'<path id="wall" d="M0 0 {way}"/>')


def circles(count):
    return svg("".join(f'<circle id="wall{i}" r="{9e7 - i}"/>' for i in range(count)))


def svg_attributes():
    names = " ".join(f'a{i}=""' for i in range(MAP // 13))
    return svg(ARENA + f"<g {names}/>")


def subpaths():
    squares = "".join(f"M{i % 1000 * 3} {i // 1000 * 3}h1v1h-1z" for i in range(1_000_000))
    return svg(f'<path id="obstacle" d="{squares}"/>')


def nested_rings(count):
    rings = "".join(f"M{-i} {-i}h{2 * i}v{2 * i}h{-2 * i}z" for i in range(1, count))
    return svg(f'<path id="obstacle" d="{rings}"/>')


# Maps in GeoJSON.

def feature(role, kind, coordinates):
    return f'{{"type":"Feature","properties":{{"role":"{role}"}},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}'


def geojson(*features):
    return ('{"type":"FeatureCollection","features":[' + ",".join(features) + "]}").encode()


def ring(count):
    turn = 2 * math.pi / count
    return ",".join(f"[{50 * math.cos(i * turn):.9f},{50 * math.sin(i * turn):.9f}]" for i in range(count))


def many_features():
    return geojson(*(feature("wall", "LineString", f"[[{i / 10},0],[{i / 10},1]]") for i in range(500_000)))


def squares():
    """As many obstacles as a map may have, all but one."""
    corners = [(0, 0), (0.05, 0), (0.05, 0.05), (0, 0.05), (0, 0)]
    def square(i):
        x, y = i % 400 / 10, i // 400 / 10
        return feature("obstacle", "Polygon", "[[" + ",".join(f"[{x + a:.2f},{y + b:.2f}]" for a, b in corners) + "]]")
    around = feature("arena", "Polygon", "[[[-1,-1],[50,-1],[50,50],[-1,50],[-1,-1]]]")
    return geojson(around, *(square(i) for i in range(131_000)))


# Drawings in DXF.

def dxf(entities, unit=4):
    groups = ["0", "SECTION", "2", "HEADER", "9", "$INSUNITS", "70", str(unit), "0", "ENDSEC"]
    groups += ["0", "SECTION", "2", "ENTITIES", *entities, "0", "ENDSEC", "0", "EOF"]
    return ("\n".join(groups) + "\n").encode()


def holes():
    plate = ["0", "LWPOLYLINE", "8", "arena", "70", "1"]
    for x, y in [(0, 0), (5000, 0), (5000, 5000), (0, 5000)]:
        plate += ["10", str(x), "20", str(y)]
    for i in range(1000):
        plate += ["0", "CIRCLE", "8", "arena", "10", str(100 + i % 32 * 150), "20", str(100 + i // 32 * 150), "40", "60"]
    return dxf(plate, 6)


def dxf_layers():
    lines = []
    for i in range(200_000):
        lines += ["0", "LINE", "8", f"wall{i}", "10", "0", "20", str(i), "11", "1", "21", str(i)]
    return dxf(lines)


def dxf_one_point():
    line = ["0", "LINE", "8", "obstacle", "10", "0", "20", "0", "11", "0", "21", "0"]
    return dxf(line * 400_000)


def dxf_spline():
    count = 300_000
    groups = ["0", "SPLINE", "8", "wall", "70", "0", "71", "5"]
    groups += [word for i in range(count + 6) for word in ("40", str(i))]
    groups += [word for i in range(count) for word in ("10", str(i * 7919 % 10007), "20", str(i * 104729 % 10007))]
    return dxf(groups)


def dxf_blocks():
    groups = ["0", "SECTION", "2", "BLOCKS"]
    for i in range(300_000):
        groups += ["0", "BLOCK", "2", f"b{i}", "0", "INSERT", "2", f"b{i + 1}", "0", "INSERT", "2", f"b{i + 1}", "0", "ENDBLK"]
    groups += ["0", "ENDSEC", "0", "SECTION", "2", "ENTITIES", "0", "INSERT", "8", "arena", "2", "b0", "0", "ENDSEC", "0", "EOF"]
    return ("\n".join(groups) + "\n").encode()


# Recordings in MCAP.

def record(kind, body):
    return struct.pack("<BQ", kind, len(body)) + body


def text(word):
    word = word.encode()
    return struct.pack("<I", len(word)) + word


def zstd_zeros(size, window=None):
    """A frame of zeros: blocks that say one byte and how often."""
    if window is None:
        frame = struct.pack("<IB", 0xFD2FB528, 0xE0) + struct.pack("<Q", size)
    else:
        frame = struct.pack("<IBB", 0xFD2FB528, 0x00, window)
    left = size
    while left > 0:
        piece = min(left, 128 * 1024)
        left -= piece
        frame += ((piece << 3) | (1 << 1) | (left == 0)).to_bytes(3, "little") + b"\0"
    return frame


def zstd_stored(stored, size):
    """A frame of zeros, so many of them stored as they are, without compression."""
    frame, left = struct.pack("<IB", 0xFD2FB528, 0xE0) + struct.pack("<Q", size), size
    while left > 0:
        piece = min(left, 128 * 1024)
        left -= piece
        raw = size - left <= stored
        frame += ((piece << 3) | (0 if raw else 1 << 1) | (left == 0)).to_bytes(3, "little") + b"\0" * (piece if raw else 1)
    return frame


def mcap_at_the_limit():
    """Inflates to almost as much as a file of its size may."""
    size = zero_records(58 * MB)
    one = chunk(zstd_stored(3 * MB, size), size, "zstd")
    return mcap(*([one] * 31))


def lz4_zeros(size):
    """A frame of one-block runs."""
    header = bytes([0x60, 0x70])
    check = 0x73
    frame = b"\x04\x22\x4d\x18" + header + bytes([check])
    left = size
    while left > 0:
        piece = min(left, 4 * 1024 * 1024)
        left -= piece
        run = piece - 1 - 5
        more, run = run - 4 - 15, b""
        block = b"\x1f\0\x01\0" + b"\xff" * (more // 255) + bytes([more % 255]) + b"\x50" + b"\0" * 5
        frame += struct.pack("<I", len(block)) + block
    return frame + b"\0\0\0\0"


def chunk(data, size, compression):
    head = struct.pack("<QQQI", 0, 1, size, 0)
    return record(6, head + text(compression) + struct.pack("<Q", len(data)) + data)


def mcap(*records):
    front = record(1, text("ros2") + text("hostile"))
    front += record(3, struct.pack("<H", 1) + text("geometry_msgs/msg/WrenchStamped") + text("ros2msg") + text(""))
    front += record(4, struct.pack("<HH", 1, 1) + text("/whisker/wrench") + text("cdr") + text(""))
    magic = b"\x89MCAP0\r\n"
    return magic + front + b"".join(records) + record(15, b"\0\0\0\0") + record(2, b"\0" * 20) + magic


def zero_records(size):
    """Zeros are records of kind 0 without content, nine bytes each."""
    return size // 9 * 9


def mcap_zstd(count, size, window=None):
    size = zero_records(size)
    return mcap(*([chunk(zstd_zeros(size, window), size, "zstd")] * count))


def mcap_lz4(count, size):
    size = zero_records(size)
    return mcap(*([chunk(lz4_zeros(size), size, "lz4")] * count))


def mcap_topics():
    return mcap(*(record(4, struct.pack("<HH", i, 1) + text(f"/w{i}/wrench") + text("cdr") + text("")) for i in range(2, 65_000)))


def wrench(i):
    head = struct.pack("<BBBB", 0, 1, 0, 0) + struct.pack("<iI", i // 1000, i % 1000 * 1_000_000)
    body = head + struct.pack("<I", 1) + b"\0" + b"\0" * 3
    body += b"\0" * (-(len(body) - 4) % 8) + struct.pack("<6d", 0, 0, 0, 0, 0, 1e-3)
    return body


def mcap_messages():
    rows = (record(5, struct.pack("<HIQQ", 1, i, i, i) + wrench(i)) for i in range(LARGE // 110))
    return mcap(*rows)


# Grids.

def png_piece(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, depth, colour, data, extra=b""):
    head = png_piece(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + extra + png_piece(b"IDAT", data) + png_piece(b"IEND", b"")


def zeros_deflated(size):
    packer = zlib.compressobj(9)
    parts = []
    while size > 0:
        piece = min(size, 1 << 22)
        parts.append(packer.compress(b"\0" * piece))
        size -= piece
    return b"".join(parts) + packer.flush()


def png_limit():
    return png(4096, 4096, 16, 6, zeros_deflated(4096 * (1 + 8 * 4096)))


def png_text():
    return png(8, 8, 8, 0, zeros_deflated(72), png_piece(b"zTXt", b"k\0\0" + zeros_deflated(900 * MB)))


def pgm_noise():
    state, rows = 1, bytearray()
    for _ in range(4096 * 4096 // 8):
        state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
        rows += bytes(255 if state >> (40 + k) & 1 else 0 for k in range(8))
    return b"P5 4096 4096 255\n" + bytes(rows)


YAML = "image: {}\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


# Robots and scenarios.

def whiskers(count):
    return "".join(f'[[whisker]]\nname = "w{i}"\nmount = [0, 0, {i % 6}]\n' for i in range(count)).encode()


ABSURD = {
    "thin": '[[whisker]]\nlength = 10\nflexural_rigidity = 1e-12\ntip_ratio = 0.001\n',
    "curved": '[[whisker]]\nlength = 0.1\ncurvature = [20, 100, -1000]\ntip_ratio = 0.01\n',
    "soft": '[[whisker]]\nbase_stiffness = 1e-9\ntip_ratio = 0.02\ncurvature = 20\n',
}


# Logs.

def columns(count):
    names = ["t", "x", "y", "theta", "moment"] + [f"c{i}" for i in range(count)]
    rows = [",".join(str(row) for _ in names) for row in range(3)]
    return ("\n".join([",".join(names), *rows]) + "\n").encode()


def whisker_columns(count):
    names = ["t", "x", "y", "theta"] + [f"w{i}.moment" for i in range(count)]
    rows = [",".join(str(row) for _ in names) for row in range(3)]
    return ("\n".join([",".join(names), *rows]) + "\n").encode()


def rows():
    lines, size, i = ["t,x,y,theta,moment\n"], 0, 0
    while size < LARGE:
        lines.append(f"{i},0,0,0,0\n")
        size += len(lines[-1])
        i += 1
    return "".join(lines).encode()


def tum():
    lines, size, i = [], 0, 0
    while size < LARGE:
        lines.append(f"{i} 0 0 0 0 0 0 1\n")
        size += len(lines[-1])
        i += 1
    return "".join(lines).encode()


MAPS = {
    "entity-text.svg": ("1 MB entity, 4,000 times, in text", entity_in_text),
    "entity-attribute.svg": ("1 MB entity, 4,000 times, in attributes", entity_in_attribute),
    "entity-nested.svg": ("entities in entities, 10^9 characters", entities_in_entities),
    "far-beziers.svg": ("200 Béziers to control points 90 km away", far_beziers),
    "circles-20.svg": ("20 circles of 90 km", lambda: circles(20)),
    "circles-300.svg": ("300 circles of 90 km", lambda: circles(300)),
    "whole.svg": ("a drawing of 95 MB", lambda: svg(ARENA + repeated("<g/>").decode())),
    "path.svg": ("a path of 31 million lines", lambda: svg(f'<path id="wall" d="M0 0{repeated("h1", MAP).decode()}"/>')),
    "nodes.svg": ("16 million elements", lambda: svg(ARENA + repeated("<g/>", MAP).decode())),
    "deep.svg": ("groups nested 10 million deep", lambda: svg(ARENA + repeated("<g>", MAP // 2).decode() + repeated("</g>", MAP // 2).decode())),
    "attributes.svg": ("5 million attributes of one element", svg_attributes),
    "subpaths.svg": ("one path of a million squares", subpaths),
    "rings.svg": ("one path of 30,000 squares within each other", lambda: nested_rings(30_000)),
    "limit-rings.svg": ("one path of 8,100 squares within each other, sound", lambda: nested_rings(8_100)),
    "name.svg": ("an id of 0.9 MB, not a role", lambda: svg(f'<rect id="{"n" * 900_000}" width="4" height="3"/>')),
    "points.geojson": ("a ring of 2 million points", lambda: geojson(feature("arena", "Polygon", f"[[{ring(2_100_000)}]]"))),
    "million.geojson": ("a ring of a million points, sound", lambda: geojson(feature("arena", "Polygon", f"[[{ring(1_000_000)}]]"))),
    "walls.geojson": ("500,000 walls", many_features),
    "squares.geojson": ("131,000 obstacles, sound", squares),
    "deep.geojson": ("lists nested deep", lambda: repeated("[", MAP)),
    "keys.geojson": ("an object of 5 million keys", lambda: b'{"a":1' + b"".join(b',"%d":1' % i for i in range(5_000_000)) + b"}"),
    "short.geojson": ("a line of 10 million points", lambda: geojson(feature("wall", "LineString", f"[[0,0]{repeated(',[1,1]', MAP).decode()}]"))),
    "long-point.geojson": ("a point of 31 million numbers", lambda: geojson(feature("wall", "LineString", f"[[0{repeated(',1', MAP).decode()}],[1,1]]"))),
    "role.geojson": ("a role of 63 MB", lambda: geojson(feature("x" * MAP, "LineString", "[[0,0],[1,1]]"))),
    "holes.dxf": ("1,000 holes of 60 m: m for mm", holes),
    "groups.dxf": ("16 million groups", lambda: b"0\nSECTION\n2\nENTITIES\n" + repeated("0\n0\n", MAP) + b"0\nENDSEC\n0\nEOF\n"),
    "layers.dxf": ("200,000 layers", dxf_layers),
    "one-point.dxf": ("400,000 lines without length at one place", dxf_one_point),
    "spline.dxf": ("a wild spline of 300,000 control points", dxf_spline),
    "blocks.dxf": ("blocks in blocks, 300,000 deep", dxf_blocks),
    "bomb.mcap": ("400 zstd chunks of 60 MB", lambda: mcap_zstd(400, 60 * MB)),
    "zeros.mcap": ("100 zstd chunks of 256 MB of zeros", lambda: mcap_zstd(100, 256 * 1024 * 1024)),
    "small-chunks.mcap": ("20,000 zstd chunks of 8 MB of zeros", lambda: mcap_zstd(20_000, 8 * MB)),
    "lz4.mcap": ("300 lz4 chunks of 60 MB of zeros", lambda: mcap_lz4(300, 60 * MB)),
    "limit.mcap": ("31 zstd chunks that inflate to 19 times their size", mcap_at_the_limit),
    "window.mcap": ("a zstd window of 2 GB and more", lambda: mcap_zstd(4, MB, 0xF8)),
    "topics.mcap": ("65,000 topics", mcap_topics),
    "limit.yaml": ("a PNG of 4096 by 4096, 16 bit colours", (png_limit, "png")),
    "huge.yaml": ("a PNG that says 60,000 by 60,000", (lambda: png(60_000, 60_000, 8, 0, zeros_deflated(MB)), "png")),
    "text.yaml": ("a PNG with 900 MB of compressed text", (png_text, "png")),
    "noise.yaml": ("a PGM of 4096 by 4096 of noise", (pgm_noise, "pgm")),
    "deep.yaml": ("lists nested deep", lambda: YAML.format("a.png").encode() + b"other: " + repeated("[", TOML - 500)),
    "lines.yaml": ("100,000 keys", lambda: YAML.format("a.png").encode() + b"".join(b"k%d:\n" % i for i in range(100_000))),
    "key.yaml": ("a key of 1 MB", lambda: b"k" * MB + b": 1\n"),
}
ROBOTS = {
    "deep.toml": ("lists nested a million deep", lambda: b"a = " + repeated("[", TOML - 10)),
    "keys.toml": ("a table of 90,000 keys", lambda: b"".join(b"k%d=1\n" % i for i in range(TOML // 11))),
    "dotted.toml": ("a key of 500,000 parts", lambda: repeated("a.", TOML - 10) + b"a = 1\n"),
    "key.toml": ("a key of 1 MB", lambda: b"k" * (TOML - 10) + b" = 1\n"),
    "whiskers.toml": ("20,000 whiskers", lambda: whiskers(20_000)),
    "thin.toml": ("a whisker of 10 m and 1e-12 N m², tapered", lambda: ABSURD["thin"].encode()),
    "curved.toml": ("a whisker that winds, tapered", lambda: ABSURD["curved"].encode()),
    "soft.toml": ("a whisker on a base of 1e-9 N m/rad", lambda: ABSURD["soft"].encode()),
    "eight.toml": ("eight such whiskers", lambda: b"".join(
        (ABSURD["curved"] + f'name = "w{i}"\nbase_stiffness = 1e-6\n').encode() for i in range(8))),
}
BEAMS = {
    "beam-thin.toml": ("the thin whisker, bent to a point", lambda: ABSURD["thin"].encode()),
    "beam-curved.toml": ("the one that winds", lambda: ABSURD["curved"].encode()),
    "beam-soft.toml": ("the one on a soft base", lambda: ABSURD["soft"].encode()),
}
LOGS = {
    "columns.csv": ("60,000 columns", lambda: columns(60_000)),
    "more-columns.csv": ("90,000 whiskers", lambda: whisker_columns(90_000)),
    "line.csv": ("one line of 95 MB", lambda: repeated("1,")),
    "rows.csv": ("7 million rows", rows),
    "quote.csv": ("a quote that never ends", lambda: b't,x,y,theta,moment\n0,0,0,0,0\n"' + repeated("1,0,0,0,0\n")),
    "name.csv": ("a column's name of 0.9 MB", lambda: b"t,x,y,theta,moment," + b"n" * 900_000 + b"\n0,0,0,0,0,0\n"),
    "messages.mcap": ("860,000 messages", mcap_messages),
    "bomb-log.mcap": ("40 zstd chunks of 60 MB", lambda: mcap_zstd(40, 60 * MB)),
}
TRUTHS = {
    "long.tum": ("4 million poses", tum),
    "line.tum": ("one line of 95 MB", lambda: repeated("1 ")),
}
FOREIGN = {
    "messages.rostopic": ("20 million lines", lambda: repeated("a: 1\n")),
    "message.rostopic": ("one message of 8 million numbers", lambda: b"".join(b"k%d: 1\n" % i for i in range(LARGE // 12)) + b"---\n"),
    "columns.foreign": ("90,000 columns", lambda: columns(90_000)),
    "serial.txt": ("16 million readings", lambda: repeated("1,2,3\n")),
}
CALIBRATIONS = {
    "deep.json": ("lists nested 4 million deep", lambda: repeated("[", JSON)),
    "list.json": ("a list of 2 million numbers", lambda: b'{"a":[1' + repeated(",1", JSON - 100) + b"]}"),
    "lists.json": ("a list of 1.4 million lists", lambda: b'{"a":[[]' + repeated(",[]", JSON - 100) + b"]}"),
}
SCENARIOS = {
    "through.toml": ("a path through 95,000 places", lambda: b"[path]\nthrough = [[0,0]" + repeated(",[0.1,0.2]", TOML - 100) + b"]\n"),
}
BATCHES = {
    "batch.csv": ("8 million cases", lambda: b"s_a,F\n" + repeated("0.07,0.05\n")),
}
