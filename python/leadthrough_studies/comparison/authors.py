"""SEDS, CLF-DM and LPV-DS as public code of their authors' laboratories learns them, beside ours.

Both learn from the same samples of all seven drawings of a motion, and both systems are run by our
code, so that what is learned differs and nothing else. The libraries are not part of this package:

    python -m leadthrough_studies.comparison.authors FOLDER results.csv

FOLDER holds `ds-opt` (github.com/nbfigueroa/ds-opt, which has the libraries of SEDS and CLF-DM) and
`lpvds` (github.com/SunannnSun/lpvds with its submodules, `damm` compiled; needs cvxpy). The MATLAB
code runs in GNU Octave with the package statistics; a call of MATLAB's `fmincon` becomes one of
Octave's `sqp`, and its k-means that of Octave.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from subprocess import DEVNULL, CalledProcessError, run
from types import ModuleType
from typing import Any, Self

import numpy as np
from scipy.special import softmax

from leadthrough.check import Float64Array
from leadthrough.errors import LeadthroughError
from leadthrough.io import lasa
from leadthrough.models import CLFDM, LPVDS, SEDS
from leadthrough.models.dynamical.field import Field
from leadthrough.models.dynamical.linear_mixture import LinearMixture
from leadthrough.models.dynamical.model import DynamicalModel, Samples
from leadthrough_studies.metrics import reproduction_errors
from leadthrough_studies.results import write_table
from leadthrough_studies.study import Row

# Of SEDS, as ours has by default; LPV-DS chooses its number on either side.
_COMPONENTS = 6
# Every so many motions: in Octave, one takes up to half a minute.
_EVERY = {"CLF-DM": 3, "SEDS, mean square": 3, "SEDS, likelihood": 3}

_FMINCON = """
function [x, f] = fmincon(obj, x0, A, b, Ae, be, lb, ub, nonl, opt)
  if strcmp(opt.GradObj, 'on')
    phi = {@(x) nth(obj, 1, 2, x), @(x) nth(obj, 2, 2, x)(:)};
    h = {@(x) -nth(nonl, 1, 4, x)(:), @(x) -nth(nonl, 3, 4, x)'};
  else
    phi = @(x) nth(obj, 1, 1, x);
    h = @(x) -nth(nonl, 1, 2, x)(:);
  end
  g = @(x) nth(nonl, 2, 2, x)(:);
  if isempty(g(x0)), g = []; end
  [x, f] = sqp(x0, phi, g, h, [], [], opt.MaxIter, 1e-8);
end
function y = nth(f, i, n, x)
  r = cell(1, n);
  [r{:}] = f(x);
  y = r{i};
end
"""
_SAVED = """
P = P(:)'; S = reshape(S, 2 * d, []);
for name = {names}, dlmwrite([name{{1}} '.txt'], eval(name{{1}}), 'precision', 17); end
"""
_BEGIN = """
pkg load statistics
addpath('.');
for part = {{'thirdparty/seds-stripped/SEDS_lib', 'thirdparty/seds-stripped/GMR_lib', ...
             'lpv-opt/CLFDM_lib'}}
  addpath(['{library}/' part{{1}}]);
end
rand('twister', 0); randn('twister', 0);
data = dlmread('data.txt'); d = size(data, 1) / 2;
"""
_SEDS = """
[P, M, S] = initialize_SEDS(data, {components});
o = struct('tol_mat_bias', 1e-6, 'display', 0, 'tol_stopping', 1e-6, 'max_iter', 500, ...
           'objective', '{objective}');
[P, M, S] = SEDS_Solver(P, M, S, data, o);
"""
_CLF_DM = """
L = {quadratics};
V = struct('L', L, 'd', d, 'w', 1e-4, 'Priors', ones(L + 1, 1) / (L + 1), 'Mu', zeros(d, L + 1));
V.P = repmat(eye(d), [1 1 L + 1]);
V = learnEnergy(V, data, struct('tol_mat_bias', 1e-1, 'display', 0, 'max_iter', 500));
[P, M, S] = EM_init_kmeans_SEDS(data, {components});
[P, M, S] = EM(data, P, M, S);
W = V.Priors(:)'; C = V.Mu; Q = reshape(V.P, d, []);
"""


@dataclass(frozen=True)
class _Octave:
    """The libraries in MATLAB, run by GNU Octave."""

    command: str
    library: Path

    def run(self, samples: Samples, script: str, names: str, **values: Any) -> list[Float64Array]:
        """The matrices of these names after a script with these values."""
        text = (_BEGIN + script).format(library=self.library, **values)
        text += _SAVED.format(names="{" + ", ".join(f"'{name}'" for name in names) + "}")
        with tempfile.TemporaryDirectory() as folder:
            np.savetxt(f"{folder}/data.txt", np.hstack([samples.x, samples.v]).T)
            Path(folder, "fmincon.m").write_text(_FMINCON, encoding="utf-8")
            Path(folder, "run.m").write_text(text, encoding="utf-8")
            run([self.command, "run.m"], cwd=folder, check=True, stdout=DEVNULL)
            return [np.loadtxt(f"{folder}/{name}.txt", delimiter=",", ndmin=2) for name in names]


@dataclass(frozen=True)
class _AuthorsSEDS(DynamicalModel):
    octave: _Octave
    objective: str

    def learn(self, samples: Samples) -> LinearMixture:
        gates, gains, _ = _mixture(
            *self.octave.run(
                samples, _SEDS, "PMS", components=_COMPONENTS, objective=self.objective
            )
        )
        return LinearMixture(gates, gains, np.eye(samples.x.shape[1]))


@dataclass(frozen=True, eq=False)
class _Gates:
    """Probabilities of the components of a mixture."""

    priors: Float64Array
    means: Float64Array
    covariances: Float64Array

    def weights(self, x: Float64Array) -> Float64Array:
        """Probabilities (n, k) at positions (n, d)."""
        away = x[:, None] - self.means
        squared = np.einsum("nki,kij,nkj->nk", away, np.linalg.inv(self.covariances), away)
        volume = np.linalg.slogdet(self.covariances)[1]
        return np.asarray(softmax(np.log(self.priors) - 0.5 * (squared + volume), axis=1))

    def arrays(self) -> Mapping[str, Any]:
        """None: nothing here is saved."""
        return {}


@dataclass(frozen=True, eq=False)
class _Stabilised(Field):
    """CLF-DM's regression and correction as the library has them; a term of the energy a row."""

    gates: _Gates
    gains: Float64Array
    constants: Float64Array
    weights: Float64Array
    centres: Float64Array
    matrices: Float64Array
    least: tuple[float, float]  # speed down the energy, 1 / the square of where it falls to 0

    name = "stabilised"

    @property
    def size(self) -> int:
        return int(self.constants.shape[1])

    def arrays(self) -> Mapping[str, Any]:
        return {}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> Self:
        raise LeadthroughError(f"arrays: expected none, as no file keeps them, got {list(arrays)}")

    def velocity(self, x: Float64Array) -> Float64Array:
        each = np.einsum("kij,nj->nki", self.gains, x) + self.constants
        velocity = (self.gates.weights(x)[:, :, None] * each).sum(axis=1)
        uphill = self._gradient(x)
        squared = (uphill**2).sum(axis=1)
        slowest, near = self.least
        rho = slowest * -np.expm1(-near * (x**2).sum(axis=1)) * np.sqrt(squared)
        excess = np.maximum((velocity * uphill).sum(axis=1) + rho, 0.0)
        return np.asarray(velocity - (excess / np.maximum(squared, 1e-300))[:, None] * uphill)

    def energy(self, states: Float64Array) -> Float64Array:
        terms, _ = self._terms(states)
        return np.asarray(self.weights[0] * terms[0] + self.weights[1:] @ terms[1:] ** 2)

    def power(self, states: Float64Array) -> Float64Array:
        return np.asarray((self._gradient(states) * self.velocity(states)).sum(axis=1))

    def _gradient(self, x: Float64Array) -> Float64Array:
        terms, slopes = self._terms(x)
        factors = self.weights[:, None] * np.vstack([np.ones_like(terms[:1]), 2.0 * terms[1:]])
        return np.asarray((factors[:, :, None] * slopes).sum(axis=0))

    def _terms(self, x: Float64Array) -> tuple[Float64Array, Float64Array]:
        """x^T P (x - c), (l, n), at least 0 after the first, and their gradients (l, n, d)."""
        along = np.einsum("lij,lnj->lni", self.matrices, x[None] - self.centres[:, None])
        values = np.einsum("lni,ni->ln", along, x)
        values[1:] = np.maximum(values[1:], 0.0)
        return values, along + np.einsum("lij,ni->lnj", self.matrices, x)


@dataclass(frozen=True)
class _AuthorsCLFDM(DynamicalModel):
    octave: _Octave
    ours: CLFDM

    def learn(self, samples: Samples) -> _Stabilised:
        settings = {"components": self.ours.components, "quadratics": self.ours.quadratics}
        *mixture, weights, centres, matrices = self.octave.run(
            samples, _CLF_DM, "PMSWCQ", **settings
        )
        d, size = len(centres), samples.scale[0]
        return _Stabilised(
            *_mixture(*mixture),
            weights[0],
            centres.T,
            matrices.reshape(d, -1, d).transpose(1, 0, 2),
            # The library's demo has 1 mm/s and 0.1 per square mm.
            (samples.duration / size, 0.1 * size**2),
        )


@dataclass(frozen=True)
class _AuthorsLPVDS(DynamicalModel):
    library: Path

    def learn(self, samples: Samples) -> LinearMixture:
        sys.modules.setdefault("casadi", ModuleType("casadi"))  # of its older solver only
        sys.path.insert(0, str(self.library))
        library = import_module("src.lpvds_class")
        # In mm and s, as the library reads these drawings.
        size, rate = samples.scale, samples.scale / samples.duration
        learned = library.lpvds_class(samples.x * size, samples.v * rate, np.zeros((1, len(size))))
        learned.begin()
        mixture, ratio = learned.damm, size[:, None] * size
        gates = _Gates(
            np.array(mixture.Prior), mixture.Mu / size, np.float64(mixture.Sigma) / ratio
        )
        metric = learned.ds_opt.P * ratio
        return LinearMixture(gates, learned.A * samples.duration, metric / np.trace(metric))


def _mixture(
    priors: Float64Array, means: Float64Array, covariances: Float64Array
) -> tuple[_Gates, Float64Array, Float64Array]:
    """Gates, gains and constants of velocities from a mixture in their columns."""
    d = len(means) // 2
    joint = covariances.reshape(2 * d, -1, 2 * d).transpose(1, 0, 2)
    spread = joint[:, :d, :d]
    gains = joint[:, d:, :d] @ np.linalg.inv(spread)
    constants = means[d:].T - np.einsum("kij,jk->ki", gains, means[:d])
    return _Gates(priors[0], means[:d].T, spread), gains, constants


def _pairs(folder: Path, octave: str) -> dict[str, tuple[DynamicalModel, DynamicalModel]]:
    """Ours and theirs by the method's name."""
    matlab = _Octave(octave, (folder / "ds-opt").resolve())
    return {
        "LPV-DS": (LPVDS(), _AuthorsLPVDS((folder / "lpvds").resolve())),
        "CLF-DM": (CLFDM(), _AuthorsCLFDM(matlab, CLFDM())),
        "SEDS, mean square": (SEDS(_COMPONENTS, "mse"), _AuthorsSEDS(matlab, "mse")),
        "SEDS, likelihood": (SEDS(_COMPONENTS), _AuthorsSEDS(matlab, "likelihood")),
    }


@dataclass(frozen=True)
class _Noted(DynamicalModel):
    """A model that notes the root mean square error of velocities, as a fraction of these."""

    model: DynamicalModel
    errors: list[float]

    def learn(self, samples: Samples) -> Field:
        field = self.model.learn(samples)
        error = np.linalg.norm(field.velocity(samples.x) - samples.v)
        self.errors.append(float(error / np.linalg.norm(samples.v)))
        return field


def compared(pair: tuple[DynamicalModel, DynamicalModel], motion: str) -> Row:
    """The mean swept areas of the drawings, mm2, and the velocity errors at the samples."""
    shown = lasa.load(motion)
    row: Row = {"motion": motion}
    for name, model in zip(("ours", "theirs"), pair, strict=True):
        velocity: list[float] = []
        skill = _Noted(model, velocity).fit(shown)
        made = [skill.generate(start=each.motion.positions[0]) for each in shown]
        errors = [
            reproduction_errors(each.motion, own) for each, own in zip(shown, made, strict=True)
        ]
        row[f"area_{name}"] = float(np.mean([each.swept_error_area for each in errors]))
        row[f"velocity_{name}"] = velocity[0]
    return row


def _summary(method: str, rows: Sequence[Row]) -> Row:
    """Means over motions that both learn, and ours over theirs, geometric, with 95 % intervals."""
    line: Row = {"method": method, "motions": len(rows)}
    drawn = np.random.default_rng(0).integers(len(rows), size=(2000, len(rows)))
    for column in ("area", "velocity"):
        ours, theirs = (
            np.array([row[f"{column}_{name}"] for row in rows]) for name in ("ours", "theirs")
        )
        ratios = np.log(ours / theirs)
        low, high = np.exp(np.quantile(ratios[drawn].mean(axis=1), (0.025, 0.975)))
        line |= {
            f"{column}_ours": float(ours.mean()),
            f"{column}_theirs": float(theirs.mean()),
            f"{column}_ratio": float(np.exp(ratios.mean())),
            f"{column}_ratio_low": float(low),
            f"{column}_ratio_high": float(high),
        }
    return line


def main() -> None:
    """Compare all methods over all motions, printing each motion's row, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="with ds-opt and lpvds")
    parser.add_argument("table", type=Path, help="the CSV file to write")
    parser.add_argument("--octave", default="octave-cli", help="the command of GNU Octave")
    options = parser.parse_args()
    table = []
    for method, pair in _pairs(options.folder, options.octave).items():
        rows = []
        for motion in lasa.motions()[:: _EVERY.get(method, 1)]:
            try:
                rows.append(compared(pair, motion))
            except (LeadthroughError, ValueError, CalledProcessError, SystemExit) as error:
                print(method, motion, "is not learned:", error, file=sys.stderr, flush=True)
            else:
                print(method, rows[-1], file=sys.stderr, flush=True)
        table.append(_summary(method, rows))
    write_table(options.table, table)


if __name__ == "__main__":
    main()
