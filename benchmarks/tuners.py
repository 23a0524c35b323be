"""Bayesian tuner against scikit-optimize: regret over evaluations on known functions, 20 seeds.

Both get the same first points (scrambled Sobol) with the same noise, the same number of
evaluations and, at their n-th evaluation, the same draw of the noise.  Ours runs with its default,
log expected improvement, on exact functions and with noisy expected improvement on noisy ones;
scikit-optimize as its `gp_minimize` does by default: Matern 5/2 kernel with a length scale each,
fitted Gaussian noise, five restarts, a portfolio of three acquisitions.  Scored is the function
without noise at the point that a tool recommends after so many evaluations: ours is `best()`; of
scikit-optimize both the sample of least posterior mean and that of least observed cost, and of
these two, at each function, the one whose median at the end is the lower.  Regrets below 1e-6 count
as 1e-6.  p values are of Wilcoxon's signed-rank test on the logarithms, paired over seeds:
`p_loss` small means that ours is the worse, `p_gain` that it is the better.  Runs that a file
has already are not repeated.

    python benchmarks/tuners.py [--quick] [--out FILE.json] [--tools pitchopt skopt] [--seeds N]
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata, util
from typing import Any

import _harness
import numpy as np

TOOLS = ("pitchopt", "skopt")
FLOOR = 1e-6
EVERY = 5
SUGGESTION_SECONDS_AIM = 0.05


@dataclass(frozen=True, kw_only=True)
class Problem:
    """A function with what a run on it is given."""

    name: str
    function: Any
    initial: int
    evaluations: int
    noise: float = 0.0

    def first(self, seed: int) -> np.ndarray:
        """First points (initial, d), the same for all tools."""
        from scipy.stats import qmc

        rng = np.random.default_rng([_harness.SEED, seed, 1])
        sobol = qmc.Sobol(len(self.function.space), scramble=True, seed=rng)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a number of points that is no power of two
            return self.function.space.from_unit(sobol.random(self.initial))

    def observer(self, seed: int) -> Callable[[Any], float]:
        """The function with the noise of one run, drawn evaluation by evaluation."""
        rng = np.random.default_rng([_harness.SEED, seed, 2])
        return lambda x: self.function(x) + self.noise * float(rng.standard_normal())

    def regret(self, x: Any) -> float:
        """Of a point, without noise."""
        return float(max(self.function(x) - self.function.minimum, FLOOR))

    def looked_at(self) -> list[int]:
        """Numbers of evaluations after which a run is scored."""
        wanted = range(self.initial, self.evaluations, EVERY)
        return [*wanted, self.evaluations]


def problems(*, quick: bool) -> list[Problem]:
    """Noise is about a tenth of the standard deviation of the function over its space, or more."""
    from pitchopt.tuning.known_functions import ackley, branin, forrester, hartmann, rosenbrock

    if quick:
        return [Problem(name="forrester", function=forrester(), initial=4, evaluations=7)]
    exact = [
        Problem(name="forrester", function=forrester(), initial=4, evaluations=15),
        Problem(name="branin", function=branin(), initial=6, evaluations=30),
        Problem(name="hartmann3", function=hartmann(3), initial=8, evaluations=30),
        Problem(name="hartmann4", function=hartmann(4), initial=10, evaluations=50),
        Problem(name="hartmann6", function=hartmann(6), initial=14, evaluations=50),
        Problem(name="ackley2", function=ackley(2), initial=6, evaluations=40),
        Problem(name="rosenbrock2", function=rosenbrock(2), initial=6, evaluations=40),
    ]
    noisy = [
        Problem(name="forrester", function=forrester(), initial=4, evaluations=30, noise=1.0),
        Problem(name="branin", function=branin(), initial=6, evaluations=40, noise=5.0),
        Problem(name="hartmann3", function=hartmann(3), initial=8, evaluations=40, noise=0.2),
        Problem(name="hartmann4", function=hartmann(4), initial=10, evaluations=50, noise=0.2),
        Problem(name="hartmann6", function=hartmann(6), initial=14, evaluations=60, noise=0.1),
    ]
    return exact + noisy


def run_pitchopt(problem: Problem, seed: int) -> dict[str, Any]:
    import pitchopt
    from pitchopt.tuning import Bayesian

    observed = problem.observer(seed)
    tuner = Bayesian(
        problem.function.space,
        seed=seed,
        start=problem.first(seed),
        initial=0,
        acquisition=("noisy-expected-improvement" if problem.noise else "log-expected-improvement"),
    )
    regrets, asking = [], 0.0
    for number in range(1, problem.evaluations + 1):
        began = time.process_time()
        candidate = tuner.ask()[0]
        asking += time.process_time() - began
        tuner.tell(candidate, observed(candidate.x))
        if number in problem.looked_at():
            regrets.append(problem.regret(tuner.best().x))
    return {
        "regrets": {"best": regrets},
        "seconds_per_suggestion": asking / (problem.evaluations - problem.initial),
        "version": pitchopt.__version__,
    }


def run_skopt(problem: Problem, seed: int) -> dict[str, Any]:
    from skopt import gp_minimize

    space, first, observed = problem.function.space, problem.first(seed), problem.observer(seed)
    began = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of points asked for twice
        found = gp_minimize(
            lambda x: observed(np.array(x)),
            list(zip(space.lower, space.upper, strict=True)),
            x0=first.tolist(),
            y0=[observed(x) for x in first],
            n_initial_points=0,
            n_calls=problem.evaluations - problem.initial,
            random_state=seed,
        )
    seconds = time.process_time() - began
    points = np.array(found.x_iters)
    seen = found.space.transform(found.x_iters)
    regrets: dict[str, list[float]] = {"mean": [], "observed": []}
    for number in problem.looked_at():
        means = found.models[number - problem.initial].predict(seen[:number])
        lowest = np.argmin(found.func_vals[:number])
        regrets["mean"].append(problem.regret(points[np.argmin(means)]))
        regrets["observed"].append(problem.regret(points[lowest]))
    return {
        "regrets": regrets,
        "seconds_per_suggestion": seconds / (problem.evaluations - problem.initial),
        "version": metadata.version("scikit-optimize"),
    }


RUNS = {"pitchopt": run_pitchopt, "skopt": run_skopt}


def suggestion(tool: str, *, samples: int, repeats: int) -> list[float]:
    """Processor seconds of suggestions with so many samples of a function of four parameters."""
    from pitchopt.tuning import Bayesian
    from pitchopt.tuning.known_functions import hartmann

    function = hartmann(4)
    first = np.random.default_rng(_harness.SEED).random((samples, 4))
    seconds = []
    if tool == "pitchopt":
        tuner = Bayesian(function.space, start=first, initial=0)
        for x in first:
            tuner.tell(tuner.ask()[0], function(x))
        for _ in range(repeats + 1):
            began = time.process_time()
            candidate = tuner.ask()[0]
            seconds.append(time.process_time() - began)
            tuner.tell(candidate, function(candidate.x))
        return seconds[1:]  # the first fit has none to start from
    from skopt import Optimizer
    from skopt.utils import cook_estimator, normalize_dimensions

    space = normalize_dimensions([(0.0, 1.0)] * 4)
    model = cook_estimator("GP", space=space, random_state=0, noise="gaussian")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        peer = Optimizer(space, model, n_initial_points=0, random_state=0)
        peer.tell(first.tolist(), [function(x) for x in first])
        for _ in range(repeats):
            x = peer.ask()
            began = time.process_time()  # it fits and searches as it is told
            peer.tell(x, function(x))
            seconds.append(time.process_time() - began)
    return seconds


def summary(report: _harness.Report, problem: Problem, runs: list[dict[str, Any]]) -> None:
    """Medians and quartiles of both tools, and their comparison over the seeds that both have."""
    from scipy.stats import wilcoxon

    mine = [r for r in runs if r["function"] == problem.name and r["noise"] == problem.noise]
    scored: dict[str, dict[int, list[float]]] = {}
    kind = {"pitchopt": "best"}
    for tool in TOOLS:
        own = {r["run"]: r["regrets"] for r in mine if r["tool"] == tool}
        if not own:
            return
        kinds = list(next(iter(own.values())))
        ends = {k: float(np.median([r[k][-1] for r in own.values()])) for k in kinds}
        kind[tool] = min(ends, key=lambda k: ends[k])
        scored[tool] = {seed: r[kind[tool]] for seed, r in own.items()}
    seeds = sorted(set(scored["pitchopt"]) & set(scored["skopt"]))
    figures: dict[str, Any] = {}
    for tool in TOOLS:
        values = np.array([scored[tool][seed] for seed in seeds])
        quartiles = np.quantile(values, (0.25, 0.5, 0.75), axis=0)
        for name, row in zip(("lower", "median", "upper"), quartiles, strict=True):
            figures[f"{tool}_{name}"] = row.tolist()
        paces = [r["seconds_per_suggestion"] for r in mine if r["tool"] == tool]
        figures[f"{tool}_seconds_per_suggestion"] = float(np.median(paces))
    lead = np.log10([scored["pitchopt"][s][-1] for s in seeds])
    lead = lead - np.log10([scored["skopt"][s][-1] for s in seeds])
    tests = {
        name: float(wilcoxon(lead, alternative=side, zero_method="zsplit").pvalue)
        for name, side in (("p_loss", "greater"), ("p_gain", "less"), ("p", "two-sided"))
    }
    report.add(
        "regret",
        function=problem.name,
        noise=problem.noise,
        seeds=len(seeds),
        initial=problem.initial,
        evaluations=problem.looked_at(),
        skopt_recommends=kind["skopt"],
        **figures,
        better=int(np.sum(lead < 0)),
        worse=int(np.sum(lead > 0)),
        **tests,
    )


def main(argv: list[str] | None = None) -> int:
    parser = _harness.parser(__doc__)
    parser.add_argument("--tools", nargs="+", default=list(TOOLS), choices=TOOLS)
    parser.add_argument("--seeds", type=int, default=20, help="runs on each function")
    args = parser.parse_args(argv)
    if args.quick:
        args.seeds = 2
    kept = _harness.finished(args.out, "run")
    report = _harness.Report("tuners", quick=args.quick, out=args.out, kept=kept)
    runs = [json.loads(line) for line in kept]
    done = {(r["function"], r["noise"], r["tool"], r["run"]) for r in runs}
    tools = [tool for tool in args.tools if tool != "skopt" or util.find_spec("skopt")]
    if len(tools) < len(args.tools):
        report.add("skipped", reason="scikit-optimize is missing: pip install 'pitchopt[bench]'")
    for seed in range(args.seeds):
        for problem in problems(quick=args.quick):
            for tool in tools:
                if (problem.name, problem.noise, tool, seed) in done:
                    continue
                runs.append(
                    {
                        "function": problem.name,
                        "noise": problem.noise,
                        "tool": tool,
                        "run": seed,
                        **RUNS[tool](problem, seed),
                    }
                )
                report.add("run", **runs[-1])
                report.close()
    for problem in problems(quick=args.quick):
        summary(report, problem, runs)
    samples, repeats = (12, 2) if args.quick else (100, 10)
    for tool in tools:
        seconds = suggestion(tool, samples=samples, repeats=repeats)
        report.add(
            "suggestion",
            tool=tool,
            samples=samples,
            dimensions=4,
            seconds=float(np.median(seconds)),
            seconds_largest=max(seconds),
            seconds_aim=SUGGESTION_SECONDS_AIM,
        )
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
