"""Peak memory of a march of 150^3 cells of float32 above its input, in a new process."""

import subprocess
import sys

import pytest

# VmHWM is of this process alone: getrusage also knows the parent that it was forked from.
PROGRAM = """
import re
from pathlib import Path
import numpy as np
import leadthrough as lt

def kilobytes(name):
    status = Path("/proc/self/status").read_text()
    return int(re.search(rf"{{name}}:\\s+(\\d+) kB", status)[1])

speed = np.ones((150, 150, 150), np.float32)
speed[::7, ::5, 3::9] = 0.5
speed[20:40, 20:130, 60:70] = 0.0
grid = lt.Grid((0.0, 0.0, 0.0), 1.0, speed.shape)
before = kilobytes("VmRSS")
{march}
print((kilobytes("VmHWM") - before) * 1024 / 1e6)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize(
    "march",
    [
        "lt.arrival_times(speed, (75, 75, 75), dtype=np.float32)",
        "lt.arrival_times(speed, (75, 75, 75), dtype=np.float32, order=2)",
        "lt.planning.ArrivalField(speed, grid, (75.0, 75.0, 75.0), dtype=np.float32).times",
    ],
)
def test_a_march_stays_below_120_megabytes(march):
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(march=march)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert 13.5 < float(result.stdout) < 120.0
