#!/usr/bin/env python3
"""Makes soup.*: the same forty random splats in the formats that are simple to write. README.md says how the others were made."""

import base64
import gzip
import json
import math
import random
import struct

COUNT, DEGREE = 40, 2
REST = (DEGREE + 1) ** 2 - 1
Y0 = 0.28209479177387814


def f32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def splat(rng):
    """Center, logarithms of extents, rotation (w, x, y, z), display value, opacity, harmonics by coefficient and channel."""
    turn = [rng.gauss(0, 1) for _ in range(4)]
    length = math.sqrt(sum(part * part for part in turn))
    return {
        "center": [f32(rng.uniform(-3, 3)) for _ in range(3)],
        "scale": [f32(rng.uniform(-5, -1)) for _ in range(3)],
        "turn": [f32(part / length) for part in turn],
        "base": [rng.uniform(0.05, 0.95) for _ in range(3)],
        "opacity": rng.uniform(0.1, 0.95),
        "rest": [[f32(rng.uniform(-0.7, 0.7)) for _ in range(3)] for _ in range(REST)],
    }


def coefficients(s):
    return [(base - 0.5) / Y0 for base in s["base"]]


def byte(value):
    return max(0, min(255, round(value)))


def ply(soup):
    names = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", *(f"f_rest_{i}" for i in range(3 * REST)), "opacity"]
    names += ["scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]
    head = f"ply\nformat binary_little_endian 1.0\ncomment SplatRenderMode: mip\nelement vertex {len(soup)}\n"
    head += "".join(f"property float {name}\n" for name in names) + "end_header\n"
    rows = b""
    for s in soup:
        rest = [s["rest"][k][c] for c in range(3) for k in range(REST)]
        logit = math.log(s["opacity"] / (1 - s["opacity"]))
        row = s["center"] + coefficients(s) + rest + [logit] + s["scale"] + s["turn"]
        rows += struct.pack(f"<{len(row)}f", *row)
    return head.encode() + rows


def color_bytes(s):
    return bytes(byte(255 * value) for value in [*s["base"], s["opacity"]])


def raw(soup):
    rows = b""
    for s in soup:
        rows += struct.pack("<6f", *s["center"], *(math.exp(scale) for scale in s["scale"])) + color_bytes(s)
        rows += bytes(byte(part * 128 + 128) for part in s["turn"])
    return rows


def ksplat(soup, mode):
    """A single section, whose buckets hold 16 splats; the last is partial."""
    capacity, block, limit = 16, 8.0, 1.0
    buckets = [soup[i : i + capacity] for i in range(0, len(soup), capacity)]
    full, last = len(soup) // capacity, len(soup) % capacity
    head = bytearray(4096)
    struct.pack_into("<BBxxIIIIH", head, 0, 0, 1, 1, 1, len(soup), len(soup), mode)
    struct.pack_into("<ff", head, 36, -limit, limit)
    section = bytearray(1024)
    partial = 1 if last and mode else 0
    of_buckets = len(buckets) if mode else 0
    struct.pack_into("<IIIIfHxxI", section, 0, len(soup), len(soup), capacity, of_buckets, block, 12, 0)
    struct.pack_into("<IIH", section, 32, full if mode else 0, partial, DEGREE)
    data = struct.pack("<I", last) if partial else b""
    middles = [[(min(a) + max(a)) / 2 for a in zip(*(s["center"] for s in bucket))] for bucket in buckets]
    if mode:
        data += b"".join(struct.pack("<3f", *middle) for middle in middles)
    bands = [range(0, 3), range(3, 8)]
    for i, s in enumerate(soup):
        scale = [math.exp(value) for value in s["scale"]]
        rest = [s["rest"][k][c] for band in bands for c in range(3) for k in band]
        if mode == 0:
            data += struct.pack("<10f", *s["center"], *scale, *s["turn"]) + color_bytes(s)
            data += struct.pack(f"<{len(rest)}f", *rest)
            continue
        middle = middles[i // capacity]
        steps = [round((a - m) * 2 * 32767 / block) + 32767 for a, m in zip(s["center"], middle)]
        data += struct.pack("<3H7e", *steps, *scale, *s["turn"]) + color_bytes(s)
        if mode == 1:
            data += struct.pack(f"<{len(rest)}e", *rest)
        else:
            data += bytes(byte((value + limit) / (2 * limit) * 255) for value in rest)
    return bytes(head) + bytes(section) + data


def spz(soup, version):
    """Axes are right, up, back: y and z have the other sign, and so has all that is odd in them."""
    signs = [-1, -1, 1, -1, 1, 1, -1, 1]
    planes = [b""] * 6
    for s in soup:
        x, y, z = s["center"]
        for value in [x, -y, -z]:
            if version == 1:
                planes[0] += struct.pack("<e", value)
            else:
                planes[0] += struct.pack("<i", round(value * 4096))[:3]
        planes[1] += bytes([byte(255 * s["opacity"])])
        planes[2] += bytes(byte((value * 0.15 + 0.5) * 255) for value in coefficients(s))
        planes[3] += bytes(byte((value + 10) * 16) for value in s["scale"])
        w, x, y, z = s["turn"]
        sign = -1 if w < 0 else 1
        planes[4] += bytes(byte((sign * part + 1) * 127.5) for part in [x, -y, -z])
        for k in range(REST):
            planes[5] += bytes(byte(signs[k] * value * 128 + 128) for value in s["rest"][k])
    head = struct.pack("<4sIIBBBB", b"NGSP", version, len(soup), DEGREE, 12, 1, 0)
    return gzip.compress(head + b"".join(planes), mtime=0)


def gltf(soup, logarithms=False):
    """glTF with the data within its text; a quarter turn of the node takes y to z."""
    q = "KHR_gaussian_splatting:"
    columns = [("POSITION", 3, [s["center"] for s in soup])]
    columns.append((q + "ROTATION", 4, [s["turn"][1:] + s["turn"][:1] for s in soup]))
    scale = [s["scale"] if logarithms else [math.exp(value) for value in s["scale"]] for s in soup]
    columns.append((q + "SCALE", 3, scale))
    columns.append((q + "OPACITY", 1, [[s["opacity"]] for s in soup]))
    columns.append((q + "SH_DEGREE_0_COEF_0", 3, [coefficients(s) for s in soup]))
    names = [(degree, at) for degree in range(1, DEGREE + 1) for at in range(2 * degree + 1)]
    for k, (degree, at) in enumerate(names):
        columns.append((f"{q}SH_DEGREE_{degree}_COEF_{at}", 3, [s["rest"][k] for s in soup]))
    data, views, accessors, attributes = b"", [], [], {}
    for name, width, rows in columns:
        values = [value for row in rows for value in row]
        packed = struct.pack(f"<{len(values)}f", *values)
        attributes[name] = len(accessors)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
        kind = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[width]
        accessors.append({"bufferView": len(accessors), "componentType": 5126, "count": len(soup), "type": kind})
        data += packed
    about = {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}
    primitive = {"attributes": attributes, "mode": 0, "extensions": {"KHR_gaussian_splatting": about}}
    half = math.sqrt(0.5)
    return json.dumps({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_gaussian_splatting"],
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"children": [1], "translation": [1, 2, 3]},
            {"mesh": 0, "rotation": [half, 0, 0, half], "scale": [2, 2, 2]},
        ],
        "meshes": [{"primitives": [primitive]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
    }).encode()


def main():
    rng = random.Random(7)
    soup = [splat(rng) for _ in range(COUNT)]
    files = {"soup.ply": ply(soup), "soup.splat": raw(soup), "soup.gltf": gltf(soup), "draft.gltf": gltf(soup, True)}
    files |= {f"soup-mode{mode}.ksplat": ksplat(soup, mode) for mode in range(3)}
    files |= {f"soup-v{version}.spz": spz(soup, version) for version in (1, 2)}
    for name, content in files.items():
        with open(name, "wb") as file:
            file.write(content)


if __name__ == "__main__":
    main()
