"""A plant of one's own, and when learning on it converges: with `ilc` alone, no turbine in it.

The loads at each rotor position are an affine function of the blades' pitches.  The factor by which
the pitch approaches its fixed point in a passage is computed beforehand and then measured; so is
what noise leaves, and what becomes of both when the loads answer otherwise than in the experiment.

    python 14_own_plant.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ilc import ActuatorLimits, FixedLearner, Layout, run
from ilc.analysis import contraction, error_margin, stationary_noise

LAYOUT = Layout(blades=3, positions=12)
SCALE = np.array([1.4e6, 3e5, 3e5, 8e4])  # torque, tilt, yaw [N m], thrust [N]
NOISE = 1e-3 * SCALE
RATE = 0.4


class AffinePlant:
    """Loads y_0 + D beta at every rotor position; D is another after a given passage."""

    blades, positions = LAYOUT.blades, LAYOUT.positions

    def __init__(self, change=0.0, after=10**9):
        random = np.random.default_rng(1)
        psi = LAYOUT.azimuth[LAYOUT.index]
        rows = [-0.5 + 0 * psi, -2 * np.cos(psi), -2 * np.sin(psi), -1 + 0 * psi]
        self.offset = SCALE * (1 + 0.02 * random.normal(size=(self.positions, 4)))
        self.jacobian = SCALE[:, None] * np.stack(rows, axis=1)
        self.jacobian *= 1 + 0.1 * random.normal(size=self.jacobian.shape)
        self.changed = self.jacobian * (1 + change * random.normal(size=self.jacobian.shape))
        self.after = after

    def passage(self, profile, number):
        """Loads (4, m) of one blade passage."""
        jacobian = self.jacobian if number < self.after else self.changed
        return (self.offset + np.einsum("klb,kb->kl", jacobian, profile[LAYOUT.index])).T


def learner():
    return FixedLearner(
        layout=LAYOUT,
        limits=ActuatorLimits(lower=-0.5, upper=0.5, step=0.5),
        start=0.0,
        setpoint=float(SCALE[0]),
        weights=SCALE[0] / SCALE,
        learning_rate=RATE,
        smoothing=1e-9,  # means that stay, as the theory has them
    )


def distances(plant, rotations):
    """Distance of the profile from where it ends, rotation by rotation [rad]."""
    profiles = run(plant, learner(), rotations=rotations).learning.profile
    return np.abs(profiles - profiles[-1]).max(axis=1)


def noise_left(passages):
    """RMS that noise adds to the exact loads of a learner that has settled without it, (4,)."""
    plant, one, random = AffinePlant(), learner(), np.random.default_rng(0)
    run(plant, one, rotations=20)
    quiet = plant.passage(one.profile, one.passages)
    squares = np.zeros(4)
    for _ in range(passages):
        loads = plant.passage(one.profile, one.passages)
        one.tell(loads + NOISE[:, None] * random.normal(size=loads.shape))
        squares += (loads - quiet).var(axis=1) / passages
    return np.sqrt(squares)


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="shorter")
    args = parser.parse_args(argv)
    rotations = 12 if args.quick else 20

    one = learner()
    run(AffinePlant(), one, rotations=0)
    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    ax = figure.add_subplot()
    for change in (0.0, 0.1, 0.3):
        plant = AffinePlant(change, after=one.experiment_passages)
        factor = contraction(plant.changed, one.gain, one.weights, RATE).pitch.max()
        found = distances(plant, rotations)
        late = rotations // 2
        measured = (found[late] / found[late - 4]) ** (1 / 12)  # four rotations, twelve passages
        print(f"slopes off by {100 * change:g} %: factor {factor:.3f}, measured {measured:.3f}")
        passages = 3 * np.arange(1, rotations + 1)
        (line,) = ax.semilogy(passages[:-1], found[:-1], "o-", label=f"{100 * change:g} %")
        ax.semilogy(passages, found[2] * factor ** (passages - 9.0), ":", color=line.get_color())
    margin = error_margin(one.jacobian, one.gain, one.weights, RATE).min()
    print(f"slopes off by up to {100 * margin:.0f} % (largest singular value) surely converge")

    expected = stationary_noise(one.jacobian, one.gain, one.weights, RATE, NOISE).rms
    left = noise_left(passages=300 if args.quick else 3000)
    for name, share, found in zip(
        ("torque", "tilt", "yaw", "thrust"), expected / NOISE, left / NOISE, strict=True
    ):
        print(f"noise in {name}: {share:.2f} of the sensor's is to stay, {found:.2f} does")

    ax.set_xlabel("passage")
    ax.set_ylabel("distance from the last profile [rad]")
    ax.legend(title="slopes off by (dotted: computed)", frameon=False)
    args.folder.mkdir(parents=True, exist_ok=True)
    path = args.folder / "14_convergence.png"
    figure.savefig(path, dpi=120)
    print(path)


if __name__ == "__main__":
    main()
