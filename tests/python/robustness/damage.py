"""Seeded damage to a good file of each format: it is read, or refused with a typed error.

`python tests/python/robustness/damage.py [ROUNDS] [FORMAT ...]` does it 2,000 times for each
format, in a process whose crash is reported; the tests do it a few dozen times.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
from pyarrow import parquet
from rosbags import rosbag1, typesys
from scipy.io import savemat

import leadthrough as lt
from leadthrough.errors import LeadthroughError
from leadthrough.io import rosbag
from leadthrough.io.reader_process import answered, bound_memory, bound_time
from leadthrough.io.table import as_request

RECORDINGS = ("csv", "npz", "mat", "json", "yaml", "mcap", "db3", "bag", "hdf5", "parquet")
OTHERS = ("urdf", "toml", "skill", "stl", "obj", "dae", "pcd", "ply", "npy", "xyz")
OPTIONS = {"hdf5": {"columns": {"joints": ["robot0_joint_pos"]}, "rate": 20.0}}
APART = {
    "mcap": "rosbag", "db3": "rosbag", "bag": "rosbag", "hdf5": "robomimic", "parquet": "lerobot",
}  # fmt: skip
CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = [(1, 2, 4), (1, 4, 3), (5, 6, 8), (5, 8, 7), (1, 2, 6), (1, 6, 5), (3, 4, 8), (3, 8, 7)]


def write_all(folder, motion):
    """Writes a good file of each format, `whole.<format>`, of a motion of joints."""
    for suffix in ("csv", "npz", "json", "yaml"):
        lt.write_motion(motion, folder / f"whole.{suffix}")
    for suffix in ("mcap", "db3"):
        rosbag.write_joint_states(motion, folder / f"whole.{suffix}")
    _write_bag(folder / "whole.bag", motion)
    savemat(folder / "whole.mat", {"t": motion.times, "pos": motion.positions[:, :3]})
    with h5py.File(folder / "whole.hdf5", "w") as file:
        file.create_dataset(
            "data/demo_0/obs/robot0_joint_pos", data=motion.positions, compression="gzip"
        )
    table = {"timestamp": motion.times, "observation.state": pa.array(motion.positions.tolist())}
    parquet.write_table(pa.table(table), folder / "whole.parquet")
    robots = Path(__file__).parents[3] / "robots" / "ur3"
    (folder / "whole.urdf").write_bytes((robots / "ur3.urdf").read_bytes())
    (folder / "whole.toml").write_bytes((robots / "limits.toml").read_bytes())
    lt.ProMP(weights=6).fit([lt.Demonstration(motion)] * 2).save(folder / "whole.skill")
    _write_meshes(folder)
    _write_points(folder)


def damaged(content, rng):
    """The content with bytes changed, its end cut off, or two parts swapped."""
    changed = bytearray(content)
    way = rng.choice(["flip", "bits", "cut", "swap", "repeat"])
    # Headers lie at both ends; half of the damage goes there.
    reach = len(content) if rng.random() < 0.5 else min(len(content), 512)
    places = rng.integers(0, reach, rng.integers(1, 5)) * rng.choice([1, -1])
    if way == "flip":
        for place in places:
            changed[place] = rng.integers(0, 256)
    elif way == "bits":
        for place in places:
            changed[place] ^= 1 << rng.integers(0, 8)
    elif way == "cut":
        del changed[rng.integers(0, len(content)) :]
    else:
        size = int(rng.integers(1, 65))
        one, two = rng.integers(0, max(1, len(content) - size), 2)
        changed[one : one + size], changed[two : two + size] = (
            content[two : two + size],
            content[one : one + size] if way == "swap" else content[two : two + size],
        )
    return bytes(changed)


def read(path):
    """Reads a file as a user would."""
    match path.suffix[1:]:
        case "urdf":
            arm = lt.Arm.from_urdf(path, base="base_link", tip="tool0")
            arm.forward_kinematics(np.zeros(len(arm.joint_names)))
        case "toml":
            whole = path.with_name("whole.urdf")
            lt.Arm.from_urdf(whole, base="base_link", tip="tool0", limits=path)
        case "skill":
            lt.load_skill(path).generate()
        case "stl" | "obj" | "dae":
            lt.read_mesh(path)
        case "pcd" | "ply" | "npy" | "xyz":
            lt.read_point_cloud(path, 0.01)
        case suffix:
            lt.read_demonstrations(path, **OPTIONS.get(suffix, {}))


def read_here(path):
    """Reads a file as `read`, but what works apart in this process, where a crash shows."""
    suffix = path.suffix[1:]
    if suffix == "dae":
        found, _ = answered(_question("mesh", "through_coal", path, None))
    elif suffix in APART:
        request = vars(as_request(**OPTIONS.get(suffix, {})))
        asked = request if APART[suffix] == "rosbag" else None
        found, _ = answered(_question(APART[suffix], "tables", path, asked))
    else:
        return read(path)
    if "error" in found:
        raise LeadthroughError(found["error"])
    return None


def _question(module, function, path, request):
    name = f"leadthrough.io.{module}"
    return {"module": name, "function": function, "path": str(path), "request": request}


def _write_bag(path, motion):
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    kind = "sensor_msgs/msg/JointState"
    writer = rosbag1.Writer(path)
    writer.set_compression(rosbag1.Writer.CompressionFormat.BZ2)
    with writer:
        connection = writer.add_connection("/joint_states", kind, typestore=store)
        for i, row in enumerate(motion.positions):
            stamp = store.types["builtin_interfaces/msg/Time"](sec=1 + i, nanosec=0)
            header = store.types["std_msgs/msg/Header"](seq=i, stamp=stamp, frame_id="")
            message = store.types[kind](
                header=header, name=list(motion.joint_names), position=row,
                velocity=np.zeros(0), effort=np.zeros(0),
            )  # fmt: skip
            writer.write(connection, (1 + i) * 10**9, store.serialize_ros1(message, kind))


def _write_meshes(folder):
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE)
    (folder / "whole.obj").write_text(corners + "".join(f"f {a} {b} {c}\n" for a, b, c in FACES))
    triangles = np.zeros(
        len(FACES), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
    )
    triangles["corners"] = np.array(CUBE, float)[np.array(FACES) - 1]
    head = bytes(80) + len(FACES).to_bytes(4, "little")
    (folder / "whole.stl").write_bytes(head + triangles.tobytes())
    numbers = " ".join(str(x) for corner in CUBE for x in corner)
    indices = " ".join(str(i - 1) for face in FACES for i in face)
    (folder / "whole.dae").write_text(
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" '
        'version="1.4.1"><asset><up_axis>Z_UP</up_axis></asset><library_geometries>'
        '<geometry id="g"><mesh><source id="p"><float_array id="a" count="24">'
        f"{numbers}</float_array><technique_common>"
        '<accessor source="#a" count="8" stride="3"><param name="X" type="float"/>'
        '<param name="Y" type="float"/><param name="Z" type="float"/></accessor>'
        '</technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/>'
        f'</vertices><triangles count="{len(FACES)}"><input semantic="VERTEX" source="#v" '
        f'offset="0"/><p>{indices}</p></triangles></mesh></geometry></library_geometries>'
        '<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node>'
        "</visual_scene></library_visual_scenes><scene>"
        '<instance_visual_scene url="#s"/></scene></COLLADA>'
    )


def _write_points(folder):
    points = np.random.default_rng(1).normal(size=(50, 3))
    np.save(folder / "whole.npy", points)
    np.savetxt(folder / "whole.xyz", points)
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 50\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    (folder / "whole.ply").write_bytes(head.encode() + points.tobytes())
    head = "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 50\nHEIGHT 1\n"
    (folder / "whole.pcd").write_bytes(
        f"{head}POINTS 50\nDATA binary\n".encode() + points.tobytes()
    )


def _motion():
    times = np.linspace(0.0, 1.0, 101)
    shape, rate = 3 * times**2 - 2 * times**3, 6 * times - 6 * times**2
    names = tuple(f"joint_{i}" for i in range(1, 7))
    ones = np.ones(6)
    return lt.JointTrajectory(times, np.outer(shape, ones), np.outer(rate, ones), joint_names=names)


def _one_format(folder, suffix, first, rounds):
    """Damages and reads; prints a line of JSON for each round, the seed before it is tried."""
    content = (folder / f"whole.{suffix}").read_bytes()
    path = folder / f"damaged.{suffix}"
    if suffix in (*APART, "dae"):
        bound_memory()
    for seed in range(first, rounds):
        path.write_bytes(damaged(content, np.random.default_rng(seed)))
        print(json.dumps(seed), flush=True)
        bound_time()  # a call without an end counts as a crash
        start = time.monotonic()
        try:
            read_here(path)
            told = "read"
        except LeadthroughError:
            told = "refused"
        except Exception as error:
            told = f"seed {seed}: {type(error).__name__}: {error}"
        print(json.dumps([told, time.monotonic() - start]), flush=True)
    print(json.dumps({"peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss}), flush=True)


def _supervised(folder, suffix, rounds):
    """How often what came of the damage, the slowest reading in s and the peak of memory in MB."""
    counts, slowest, peak, first = Counter(), 0.0, 0, 0
    while first < rounds:
        command = [sys.executable, __file__, "--one", str(folder), suffix, str(first), str(rounds)]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        for line in run.stdout.splitlines():
            match json.loads(line):
                case int() as seed:
                    first = seed + 1
                case [told, seconds]:
                    counts[told] += 1
                    slowest = max(slowest, seconds)
                case {"peak": kilobytes}:
                    peak = max(peak, kilobytes // 1024)
        if run.returncode == 0:
            break
        counts[_through_the_front(folder, suffix, first - 1, run)] += 1
    return counts, slowest, peak


def _through_the_front(folder, suffix, seed, run):
    content = (folder / f"whole.{suffix}").read_bytes()
    path = folder / f"crashing.{suffix}"
    path.write_bytes(damaged(content, np.random.default_rng(seed)))
    try:
        read(path)
    except LeadthroughError:
        return "crashed, refused from outside"
    return f"seed {seed}: ended with {run.returncode}: {run.stderr[-200:]}"


def main(arguments):
    """Prints a line for each format; ends with 1 if an untyped error came."""
    if arguments[:1] == ["--one"]:
        _one_format(Path(arguments[1]), arguments[2], *map(int, arguments[3:]))
        return 0
    rounds = int(arguments[0]) if arguments else 2000
    wrong = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_all(folder, _motion())
        for suffix in arguments[1:] or (*RECORDINGS, *OTHERS):
            counts, slowest, peak = _supervised(folder, suffix, rounds)
            expected = ("read", "refused", "crashed, refused from outside")
            listed = ", ".join(f"{counts[each]} {each}" for each in expected)
            print(f"{suffix:8s} {listed}; slowest {slowest:.2f} s, peak {peak} MB", flush=True)
            for told in counts.keys() - set(expected):
                wrong += counts[told]
                print(f"    {counts[told]} x {told}", flush=True)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
