"""ProMP of seven drawings, conditioned on via points.

Writes conditioned.png: python python/demos/15_promp_conditioning.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
import probability
from leadthrough.show import plot

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

shown = lt.io.lasa.load("Sshape")  # mm, as recorded
skill = lt.ProMP().fit(shown)
times = np.linspace(0.0, skill.duration, 200)

middle, goal = 0.5 * skill.duration, skill.duration
via = skill.distribution([middle])[0][0] + (0.0, 4.0)
narrowed = skill.condition([middle, goal], [via, (0.0, 0.0)])
limited = narrowed.within((-np.inf, -np.inf), (np.inf, 46.0))

figure = plt.figure(figsize=(10, 6), layout="constrained")
(drawing, bands), (functions, conditioned) = figure.subplots(2, 2)
paths = [demonstration.motion.positions for demonstration in shown]
plot.draw_paths(drawing, paths, plot.DEMONSTRATION, label="demonstrations")
samples = [motion.positions for motion in narrowed.sample(10, seed=0)]
plot.draw_paths(drawing, samples, probability.SAMPLE, label="samples through the via point")
plot.draw_paths(drawing, [narrowed.generate().positions], plot.PATH, label="their mean")
drawing.plot(*via, **probability.OBSERVED)
drawing.set_aspect("equal")
drawing.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
probability.draw_basis(functions, skill)
functions.set_title("basis functions", fontsize=10)
probability.draw_band(bands, times, *skill.distribution(times), 1)
probability.draw_samples(bands, skill.sample(10, seed=1), 1)
bands.set_title("y in mm: mean, two standard deviations, samples", fontsize=10)
probability.draw_band(conditioned, times, *narrowed.distribution(times), 1, label="conditioned")
mean = limited.distribution(times)[0][:, 1]
conditioned.plot(times, mean, color="C1", label="kept below 46 mm")
conditioned.plot([middle, goal], [via[1], 0.0], **probability.OBSERVED)
conditioned.legend(fontsize=8)
figure.savefig(folder / "conditioned.png", dpi=110)

own = np.mean([skill.log_likelihood(each.motion) for each in shown])
other = skill.log_likelihood(lt.io.lasa.load("GShape")[0].motion)
print(f"log-likelihood of the demonstrations {own:.0f} on the mean, of another motion {other:.0f}")
print(f"wrote {folder / 'conditioned.png'}")
