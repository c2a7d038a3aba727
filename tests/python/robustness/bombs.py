"""Small files that inflate far, nest deep or never end: each is written by a function here."""

import sqlite3
import struct
import zipfile
import zlib

import h5py
import lz4.frame
import numpy as np
import pyarrow as pa
from pyarrow import parquet

import leadthrough as lt
from leadthrough.io import rosbag

MIB = 2**20


def deflated_zeros(mebibytes):
    """A zlib stream of zeros; one block is repeated, so that it takes no time to make."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    block = packer.compress(bytes(MIB)) + packer.flush(zlib.Z_FULL_FLUSH)
    checksum = 1 | (mebibytes * MIB % 65521) << 16
    return b"\x78\x9c" + mebibytes * block + b"\x03\x00" + struct.pack(">I", checksum)


def packed_zeros():
    """An LZ4 frame of two gigabytes of zeros."""
    packer = lz4.frame.LZ4FrameCompressor(block_size=lz4.frame.BLOCKSIZE_MAX4MB)
    parts = [packer.begin()]
    parts += [packer.compress(bytes(4 * MIB)) for _ in range(512)]
    return b"".join([*parts, packer.flush()])


def npz_of_zeros(path):
    """A gigabyte of zeros in three arrays, each below the bound."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name in ("times", "positions", "joints"):
            with archive.open(f"{name}.npy", "w") as file:
                np.lib.format.write_array(file, np.zeros(12 * MIB))


def npz_of_small_numbers(path):
    """Numbers of one byte, which would take eight."""
    np.savez_compressed(path, joints=np.zeros((40 * MIB, 6), np.int8))


def npz_of_nothing(path):
    """A billion texts without a letter, which take no byte in the file."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, kind, shape in (("joints", "<f8", (0, 1)), ("joint_names", "<U0", (10**9,))):
            with archive.open(f"{name}.npy", "w") as file:
                header = {"descr": kind, "fortran_order": False, "shape": shape}
                np.lib.format.write_array_header_1_0(file, header)


def npz_of_empty_members(path):
    """Twenty thousand members."""
    with zipfile.ZipFile(path, "w") as archive:
        for i in range(20_000):
            archive.writestr(str(i), b"")


def _mat(path, *variables):
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
    parts = (struct.pack("<II", 15, len(each)) + each for each in variables)
    path.write_bytes(head + b"".join(parts))


def mat_of_zeros(path):
    """One variable that inflates to two gigabytes."""
    _mat(path, deflated_zeros(2048))


def mat_of_many_variables(path):
    """Twenty variables, each below the bound."""
    body = bytes(100 * MIB)
    head = struct.pack("<8I", 14, 48 + len(body), 6, 8, 6, 0, 5, 8)
    head += struct.pack("<2i4I", len(body), 1, 1, 0, 1, len(body))
    _mat(path, *([zlib.compress(head + body, 1)] * 20))


def mat_of_empty_cells(path):
    """A cell array of 17 million empty matrices of eight bytes."""
    count = 17_000_000
    body = struct.pack("<II", 14, 0) * count
    head = struct.pack("<8I", 14, 40 + len(body), 6, 8, 1, 0, 5, 8)
    head += struct.pack("<2i2I", count, 1, 1, 0)
    _mat(path, zlib.compress(head + body, 1))


def mat_of_cells_in_cells(path):
    """Cells nested fifty thousand deep."""
    content = b""
    for _ in range(20_000):
        size = 40 + len(content)
        content = struct.pack("<8I2i2I", 14, size, 6, 8, 1, 0, 5, 8, 1, 1, 1, 0) + content
        if size > MIB:
            break
    _mat(path, zlib.compress(content, 1))


def parquet_of_one_number(path):
    """120 million times the same number, in 24 lists of one column."""
    column = pa.array(np.full(5 * MIB, 0.5))
    lists = pa.ListArray.from_arrays(pa.array([0, len(column)], pa.int32()), column)
    table = pa.table({"timestamp": [0.0], "observation.state": lists})
    with parquet.ParquetWriter(path, table.schema) as writer:
        for _ in range(24):
            writer.write_table(table)


def parquet_of_many_rows(path):
    """Forty million rows."""
    table = pa.table({"observation.state": pa.array(np.zeros(8 * MIB))})
    with parquet.ParquetWriter(path, table.schema) as writer:
        for _ in range(5):
            writer.write_table(table)


def hdf5_of_one_chunk(path):
    """A chunk that says it has 80 bytes and inflates to two gigabytes."""
    with h5py.File(path, "w") as file:
        made = file.create_dataset(
            "data/demo_0/obs/robot0_joint_pos", (10, 1), "f8", chunks=(10, 1), compression="gzip"
        )
        made.id.write_direct_chunk((0, 0), deflated_zeros(2048))
        file["data/demo_0/obs/time"] = np.arange(10.0)


def hdf5_of_a_vast_chunk(path):
    """Ten numbers in a chunk of two gigabytes."""
    with h5py.File(path, "w") as file:
        made = file.create_dataset(
            "data/demo_0/obs/robot0_joint_pos", (10, 1), "f8", chunks=(2**28 - 1, 1),
            maxshape=(None, 1), compression="gzip",
        )  # fmt: skip
        made.id.write_direct_chunk((0, 0), deflated_zeros(2047))
        file["data/demo_0/obs/time"] = np.arange(10.0)


def hdf5_of_another_file(path):
    """Numbers that lie in another file of the disk."""
    with h5py.File(path, "w") as file:
        file.create_dataset(
            "data/demo_0/obs/robot0_joint_pos", (10, 1), "u1", external=[("/etc/passwd", 0, 10)]
        )


def _mcap(path, compression, content):
    """A bag of one chunk that says it has 1,000 bytes."""

    def record(kind, body):
        return struct.pack("<BQ", kind, len(body)) + body

    def text(value):
        return struct.pack("<I", len(value)) + value.encode()

    def times(count):
        return struct.pack("<QQQ", 0, 1, count)

    magic = b"\x89MCAP0\r\n"
    chunk = record(6, times(1000) + struct.pack("<I", 0) + text(compression)
                   + struct.pack("<Q", len(content)) + content)  # fmt: skip
    head = magic + record(1, text("ros2") + text("")) + chunk + record(15, struct.pack("<I", 0))
    definition = b"float64 x"
    schema = record(3, struct.pack("<H", 1) + text("sensor_msgs/msg/JointState") + text("ros2msg")
                    + struct.pack("<I", len(definition)) + definition)  # fmt: skip
    channel = record(4, struct.pack("<HH", 1, 1) + text("/joint_states") + text("cdr")
                     + struct.pack("<I", 0))  # fmt: skip
    counts = struct.pack("<IHQ", 10, 1, 100)
    statistics = record(11, struct.pack("<QHIIIIQQ", 100, 1, 1, 0, 0, 1, 0, 1) + counts)
    at = len(head) - 13 - len(chunk)  # of the chunk; the record after it has 13 bytes
    index = record(8, struct.pack("<QQQQ", 0, 1, at, len(chunk))
                   + struct.pack("<IHQ", 10, 1, at + len(chunk)) + struct.pack("<Q", 31)
                   + text(compression)
                   + struct.pack("<QQ", len(content), 1000))  # fmt: skip
    start = len(head)
    footer = record(2, struct.pack("<QQI", start, 0, 0))
    path.write_bytes(head + schema + channel + statistics + index + footer + magic)


def mcap_of_zeros(path):
    """A compressed chunk that inflates to two gigabytes, whatever it says."""
    _mcap(path, "lz4", packed_zeros())


def mcap_that_says_so(path):
    """A chunk that claims ten gigabytes."""
    rosbag.write_joint_states(_motion(), path)
    content = bytearray(path.read_bytes())
    at, kind = 8, 0
    while kind != 6:  # records: a kind, a length, and of a chunk two times and its size
        kind, length = struct.unpack_from("<BQ", content, at)
        at += 9 + length
    struct.pack_into("<Q", content, at - length + 16, 10**10)
    path.write_bytes(content)


def db3_without_end(path):
    """Messages that the data base makes up without end."""
    rosbag.write_joint_states(_motion(), path)
    with sqlite3.connect(path) as base:
        base.execute("ALTER TABLE messages RENAME TO old")
        base.execute(
            "CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1"
            " FROM n) SELECT i AS id, topic_id, i AS timestamp, data FROM n, old"
        )
    base.close()


def db3_of_vast_messages(path):
    """Messages of 900 megabytes that the data base makes up."""
    rosbag.write_joint_states(_motion(), path)
    with sqlite3.connect(path) as base:
        base.execute("ALTER TABLE messages RENAME TO old")
        base.execute(
            "CREATE VIEW messages AS SELECT id, topic_id, timestamp, zeroblob(900000000) AS data"
            " FROM old"
        )
    base.close()


def bag_of_zeros(path):
    """A chunk of a ROS 1 bag that inflates to two gigabytes."""

    def record(fields, data):
        parts = (key + b"=" + value for key, value in fields.items())
        head = b"".join(struct.pack("<I", len(part)) + part for part in parts)
        return struct.pack("<I", len(head)) + head + struct.pack("<I", len(data)) + data

    chunk = record(
        {b"op": b"\x05", b"compression": b"lz4", b"size": struct.pack("<I", 1000)}, packed_zeros()
    )
    start = len(b"#ROSBAG V2.0\n")
    head = {
        b"op": b"\x03",
        b"conn_count": struct.pack("<I", 1),
        b"chunk_count": struct.pack("<I", 1),
    }
    empty = len(record({**head, b"index_pos": struct.pack("<Q", 0)}, b""))
    place = start + empty
    chunk += record(
        {b"op": b"\x04", b"ver": struct.pack("<I", 1), b"conn": struct.pack("<I", 0),
         b"count": struct.pack("<I", 1)},
        struct.pack("<III", 0, 1, 0),
    )  # fmt: skip
    first = record({**head, b"index_pos": struct.pack("<Q", place + len(chunk))}, b"")
    kind = {
        b"topic": b"/joint_states",
        b"type": b"sensor_msgs/JointState",
        b"md5sum": b"76b81e0561db142e2fc5c30d562dc4be",
        b"message_definition": b"float64 x\n",
    }
    kind_fields = b"".join(
        struct.pack("<I", len(k) + 1 + len(v)) + k + b"=" + v for k, v in kind.items()
    )
    connection = record(
        {b"op": b"\x07", b"conn": struct.pack("<I", 0), b"topic": b"/joint_states"}, kind_fields
    )
    info = record(
        {b"op": b"\x06", b"ver": struct.pack("<I", 1), b"chunk_pos": struct.pack("<Q", place),
         b"start_time": bytes(8), b"end_time": struct.pack("<II", 1, 0),
         b"count": struct.pack("<I", 1)},
        struct.pack("<II", 0, 1),
    )  # fmt: skip
    path.write_bytes(b"#ROSBAG V2.0\n" + first + chunk + connection + info)


def _motion():
    times = np.linspace(0.0, 1.0, 11)
    return lt.JointTrajectory(times, times[:, None], joint_names=("a",))


def _laughs(count):
    return "".join(
        f'<!ENTITY l{i} "{10 * f"&l{i - 1};"}">' if i else '<!ENTITY l0 "lol">'
        for i in range(count)
    )


TEXTS = {
    # A header of a million names.
    "csv_of_a_million_columns": lambda: ",".join(f"c{i}" for i in range(1_000_000)) + "\n",
    # A line of 200 megabytes.
    "csv_of_one_line": lambda: b"t,x,y\n" + b"1" * (200 * MIB),
    # Twenty million rows of one number, 40 megabytes that took gigabytes as lists of texts.
    "csv_of_short_rows": lambda: b"x\n" + b"1\n" * 20_000_000,
    # An event whose name nests deep.
    "csv_with_a_deep_event": lambda: "# event,0.5," + "[" * 100_000 + "\nt,x,y\n0,1,2\n1,2,3\n",
    # A million brackets.
    "json_that_nests": lambda: "[" * 1_000_000,
    # Ten million lists in 30 megabytes.
    "json_of_empty_lists": lambda: (
        '{"joint_names": ["a"], "points": [' + "[]," * 10_000_000 + "[]]}"
    ),
    # A hundred megabytes of which one letter takes four bytes, and so all do.
    "json_of_wide_letters": lambda: '{"joint_names": ["' + "a" * 100_000_000 + '\U0001f600"]}',
    # A billion laughs.
    "yaml_of_aliases": lambda: "\n".join(
        [
            'a0: &a0 ["ha", "ha"]',
            *(f"a{i}: &a{i} [{', '.join(9 * [f'*a{i - 1}'])}]" for i in range(1, 12)),
        ]
    ),
    # Brackets and blocks within each other, deep enough to overflow the loader's stack.
    "yaml_that_nests": lambda: "points: " + "[" * 100_000 + "]" * 100_000,
    # Ten million numbers, for each of which the loader takes 400 bytes.
    "yaml_of_many_numbers": lambda: "points: [" + "1, " * 10_000_000 + "1]",
    # One number of two million parts in base 60.
    "yaml_in_base_60": lambda: "points: 1" + ":1" * 500_000,
    # Keys that all have the same hash.
    "yaml_of_colliding_keys": lambda: "".join(f"{i * (2**61 - 1)}: 1\n" for i in range(1, 60_000)),
    # A text mesh whose first vertex is a word of 200 megabytes.
    "stl_of_words": lambda: b"solid\nvertex " + b"1" * (200 * MIB) + b" 0 0\n",
    # A polygon of forty million corners.
    "obj_of_one_polygon": lambda: b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + b" 1" * 40_000_000,
    # A billion laughs, as a COLLADA mesh.
    "dae_of_entities": lambda: (
        f'<?xml version="1.0"?><!DOCTYPE c [{_laughs(10)}]><COLLADA>&l9;</COLLADA>'
    ),
}


def _texts(suffix):
    """Makers of the files of a format that are nothing but a text."""

    def maker(name):
        def write(path):
            content = TEXTS[name]()
            path.write_bytes(content.encode() if isinstance(content, str) else content)

        write.__name__ = name
        return write

    return tuple(maker(name) for name in TEXTS if name.startswith(f"{suffix}_"))


RECORDINGS = {
    "npz": (npz_of_zeros, npz_of_small_numbers, npz_of_nothing, npz_of_empty_members),
    "mat": (mat_of_zeros, mat_of_many_variables, mat_of_empty_cells, mat_of_cells_in_cells),
    **{suffix: _texts(suffix) for suffix in ("csv", "json", "yaml")},
    "parquet": (parquet_of_one_number, parquet_of_many_rows),
    "hdf5": (hdf5_of_one_chunk, hdf5_of_a_vast_chunk, hdf5_of_another_file),
    "mcap": (mcap_of_zeros, mcap_that_says_so),
    "db3": (db3_without_end, db3_of_vast_messages),
    "bag": (bag_of_zeros,),
}  # fmt: skip
MESHES = {suffix: _texts(suffix) for suffix in ("stl", "obj", "dae")}
