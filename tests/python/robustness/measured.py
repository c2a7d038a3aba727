"""Reads files in a process of its own and tells what came, how long it took and how much memory.

Time and memory are those of this process and its reader process together: processor time for all
files, and the sum of what each took at most.
"""

import json
import subprocess
import sys

PROGRAM = """
import json, resource, sys
from pathlib import Path
import leadthrough as lt
from leadthrough.errors import LeadthroughError
from leadthrough.io import reader_process, mesh

told = []
for name in sys.argv[1:]:
    path = Path(name)
    try:
        if path.suffix in (".stl", ".obj", ".dae"):
            mesh.read_triangles(path)
        else:
            lt.io.read_recordings(path)
        answer = "read"
    except LeadthroughError as error:
        answer = str(error)
    told.append(answer)
reader_process.end()
used = [resource.getrusage(kind) for kind in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
seconds = sum(each.ru_utime + each.ru_stime for each in used)
print(json.dumps([told, seconds, sum(each.ru_maxrss for each in used) * 1024]))
"""


def read(*paths):
    """Outcome of each file, the seconds for all, and the bytes of memory taken at most.

    An outcome is "read" or the message of a typed error; any other error raises here.
    """
    # The peak of a process counts from that of the one it was started from, so that another one,
    # small as it is, stands between the tests' and the one that is measured.
    between = "import subprocess, sys; sys.exit(subprocess.call(sys.argv[1:]))"
    command = [sys.executable, "-c", between, sys.executable, "-c", PROGRAM, *map(str, paths)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    told, seconds, memory = json.loads(run.stdout)
    return told, seconds, memory
