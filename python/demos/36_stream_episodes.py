"""Stream of a thousand episodes: faults of each, and a skill of the sound ones.

Needs the extra hdf5. Writes faults.json, episodes.npz and episodes.png:
python python/demos/36_stream_episodes.py [FOLDER]
"""

import json
import sys
from pathlib import Path

import h5py
import numpy as np

import leadthrough as lt

EPISODES = 1000
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
data_set = folder / "low_dim.hdf5"
rng = np.random.default_rng(0)
phase = np.linspace(0.0, 1.0, 40)[:, None]
with h5py.File(data_set, "w") as file:  # as robomimic writes it
    arguments = json.dumps({"env_kwargs": {"control_freq": 20}})
    file.create_group("data").attrs["env_args"] = arguments
    for number in range(EPISODES):
        rows = phase**2 * (3 - 2 * phase) * [0.5, -0.3, 0.8] + rng.normal(0.0, 0.01, 3)
        if rng.uniform() < 0.05:
            rows[rng.integers(40, size=3)] = np.nan  # samples that were lost
        if rng.uniform() < 0.01:
            rows[:] = np.nan  # a whole episode
        file[f"data/demo_{number}/obs/robot0_joint_pos"] = rows

shown, faults, problems = [], {}, {}
for episode in lt.io.stream_recordings(data_set):
    assert episode.recording is not None, episode.problem
    try:
        motion, report = lt.preprocess.clean(episode.recording)
    except lt.errors.InvalidInput as error:
        problems[episode.name] = str(error)
        continue
    if report.invalid:
        faults[episode.name] = len(report.invalid)
    shown.append(motion)
print(f"{len(shown)} of {EPISODES} episodes are usable; {len(faults)} have lost samples")
file = folder / "faults.json"
file.write_text(json.dumps({"samples lost": faults, "left out": problems}, indent=1))
skill = lt.ProMP(weights=10).fit(shown)
skill.save(folder / "episodes.npz")
skill.plot().savefig(folder / "episodes.png", dpi=110)
print(f"learned: {skill}")
print(f"wrote {file} and {folder / 'episodes.png'}")
