#!/usr/bin/env python3
"""Makes this folder from the folder of real clouds: small files as they are, every nth point of larger ones.

usage: tests/data/cut.py FOLDER, a folder as tests/data/README.md describes it
"""

import shutil
import struct
import sys
from pathlib import Path

HERE = Path(__file__).parent

# Files as they are.
WHOLE = """
formats/1.2-with-color.las formats/1.2-with-color.ptx formats/5points_double_ascii.ply formats/autzen.pts
formats/las14_test1_4.las formats/las_extrabytes.las formats/laz_pointwise_nochunk.laz formats/points_agisoft.xyz
formats/points_cloudcompare.xyz formats/simple_binary_le.ply formats/test.pts
nasty/100-points.las nasty/autzen-utm.pcd nasty/bad-geotiff-keys.las nasty/bad_vlr_count.las nasty/badheader.txt
nasty/cartesian_invalid_state_single.e57 nasty/corrupt_crc.e57 nasty/crlf_test.txt nasty/crop_duplicate.laz
nasty/duplicates-unsorted.txt nasty/empty.e57 nasty/empty_pc.e57 nasty/example_with_invalid_comments.ply
nasty/example_with_invalid_comments_little_endian.ply nasty/issue_2421.ply nasty/laszip_broken_coder.laz
nasty/laszip_broken_compressor.laz nasty/laszip_broken_size.laz nasty/lots_of_vlr.las nasty/mesh.ply
nasty/missingheader.txt nasty/no-points.las nasty/no_ext_namespace.e57 nasty/no_vertex.ply
nasty/pdalfail_0643_6319.laz nasty/points_emptyascii.ply nasty/points_emptyface.ply nasty/quoted.txt
nasty/read_error.e57 nasty/scaled_integer_intensity.e57 nasty/simple_text_trailing_space.ply nasty/single_point.laz
nasty/sized_dims.ply nasty/spurious.las nasty/text_extradim.ply nasty/tiny_pc_with_extension.e57
nasty/tiny_spherical.e57 nasty/unregistered_extra_bytes.las nasty/utm17.las nasty/utm17_comma.pcd
nasty/utm17_space.pcd nasty/utm17_tab.pcd
""".split()


def every(records: bytes, size: int, step: int) -> tuple[bytes, int]:
    """Every `step`th of records of `size` bytes, and how many those are."""
    kept = [records[at : at + size] for at in range(0, len(records) - size + 1, size * step)]
    return b"".join(kept), len(kept)


def cut_ply(text: bytes, size: int, step: int) -> bytes:
    """Cuts a binary PLY file that holds vertices alone."""
    header, body = text.split(b"end_header\n", 1)
    before, rest = header.split(b"element vertex ", 1)
    _, after = rest.split(b"\n", 1)
    kept, count = every(body, size, step)
    return b"%selement vertex %d\n%send_header\n%s" % (before, count, after, kept)


def cut_pcd(text: bytes, size: int, step: int) -> bytes:
    """Cuts a binary PCD file of one row."""
    header, body = text.split(b"DATA binary\n", 1)
    kept, count = every(body, size, step)
    lines = [b"%s %d" % (line.split()[0], count) if line.startswith((b"WIDTH", b"POINTS")) else line
             for line in header.splitlines()]
    return b"\n".join(lines) + b"\nDATA binary\n" + kept


def cut_las(text: bytes, step: int) -> bytes:
    """Cuts a LAS file up to 1.3; bounds and counts by return stay those of the whole."""
    start, = struct.unpack_from("<I", text, 96)
    size, count = struct.unpack_from("<HI", text, 105)
    kept, left = every(text[start : start + size * count], size, step)
    header = bytearray(text[:start])
    struct.pack_into("<I", header, 107, left)
    return bytes(header) + kept


def cut_volume(text: bytes, side: int) -> bytes:
    """Every second voxel of each axis, of one byte each."""
    half = range(0, side, 2)
    return bytes(text[(z * side + y) * side + x] for z in half for y in half for x in half)


CUTS = {
    "models/turbine_blade_6k.ply": ("models/turbine_blade_100k.ply", lambda text: cut_ply(text, 24, 16)),
    "indoor/livingroom_fragment_2k.ply": ("indoor/livingroom_fragment_double.ply", lambda text: cut_ply(text, 27, 56)),
    "indoor/redwood_fragment_1k.pcd": ("indoor/redwood_fragment.pcd", lambda text: cut_pcd(text, 32, 100)),
    "lidar/sample_c_2k.las": ("lidar/sample_c_rgb_classified.las", lambda text: cut_las(text, 7)),
    "volumes/neghip_32x32x32_uint8.raw": ("volumes/neghip_64x64x64_uint8.raw", lambda text: cut_volume(text, 64)),
}


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    source = Path(sys.argv[1])
    for name in WHOLE:
        (HERE / name).parent.mkdir(exist_ok=True)
        shutil.copyfile(source / name, HERE / name)
    for name, (whole, cut) in CUTS.items():
        (HERE / name).parent.mkdir(exist_ok=True)
        (HERE / name).write_bytes(cut((source / whole).read_bytes()))


main()
