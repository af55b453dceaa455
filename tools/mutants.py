"""Mutation testing: `make mutants` plants faults in the code that judges or computes claims and counts those found.

cosmic-ray makes the mutants: another operator, number, comparison, decorator or control word at one place. At each
place at most one is chosen at random, and a fixed number of places per group of modules. A mutant is killed when a test
of its group that executes it fails, or when these tests take three times their processor time. It exists in the memory
of one process only. `mutation.py` plants it and chooses the tests.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import json
import os
import random
import sys
import time
from dataclasses import dataclass
from importlib import import_module
from itertools import zip_longest
from pathlib import Path

from mutation import Mutant, Suite, cpu_time

ROOT = Path(__file__).resolve().parents[1]
SLOW = "-k=not " + " and not ".join(
    (
        "browser",
        "reproducible",
        "well_formed",
        "unusual",
        "every_signal",
        "figure",
        "(combination_passes and (orient or implicit or mesh or tube or line))",
    )
)
"""Tests that take long, and tests of pictures. Modules that only draw are not mutated."""
GROUPS = {
    "units": (["palpate/base/values/*.py"], ["scene_file/test_scene_values.py", "scene_file/test_values_refused.py"]),
    "report energies": (
        ["palpate/report/energy.py", "palpate/report/summary.py", "palpate/session/summary.py"],
        ["report/test_report_summary.py", "report/test_report_elements.py", "report/test_report_touches.py",
         "report/test_report_page.py", "report/test_summary_totals.py"]),
    "operators": (["palpate/simulators/operators/*.py"], ["operators"]),
    "certificate": (["palpate/devices/certificate/[!f]*.py"], ["certificate"]),
    "studies": (
        [f"lab/palpate_lab/studies/{name}" for name in (
            "guidance/effects.py", "guidance/work.py", "guidance/cues.py", "guidance/tasks.py", "wall/fit.py",
            "wall/bench.py", "wall/work.py", "passivity/work.py", "certificate/[!f]*.py")],
        ["studies/test_study_certificate.py", "studies/test_study_wall.py", "studies/test_study_passivity.py",
         "studies/test_study_guidance.py", "studies/test_guidance_trials.py",
         "certificate/test_scene_certificate.py"]),
    "conformance": (["lab/palpate_lab/verify/conformance/*.py"], ["verify/conformance"]),
}  # fmt: skip
"""Modules to mutate, and the tests that hold their claims."""
PRELOADED = ("pytest", "numpy", "scipy.optimize", "scipy.spatial.transform", "scipy.linalg", "scipy.signal",
             "scipy.stats", "hypothesis", "pydantic", "yaml", "trimesh", "tyro", "rich.console", "mcap.reader",
             "mcap.writer")  # fmt: skip
"""Modules that every test process starts with."""
PRELOADED_BUT_FOR_UNITS = ("palpate.scene", "palpate.scene.guidance")
"""Further ones, which import no module that a later group mutates."""


def without_effect(tree: ast.AST) -> set[tuple[int, int]]:
    """Places (line, column) in annotations, which are never evaluated, and in options of `dataclass` (`frozen`)."""
    roots = [getattr(node, name, None) for node in ast.walk(tree) for name in ("annotation", "returns")]
    roots += [one for node in ast.walk(tree) if isinstance(node, ast.ClassDef) for one in node.decorator_list]
    spans = [
        (r.lineno, r.col_offset, r.end_lineno or 0, r.end_col_offset or 0) for r in roots if isinstance(r, ast.expr)
    ]
    return {(line, column) for a, b, c, d in spans for line in range(a, c + 1)
            for column in range(b if line == a else 0, d if line == c else 500)}  # fmt: skip


@dataclass(frozen=True)
class Place:
    """A place in a file, and what changes there."""

    path: Path
    line: int
    operator: str
    occurrence: int
    """Index of the place among those of the operator in the file."""

    def mutant(self) -> Mutant:
        """The mutant; raises AttributeError for an exception given by its dotted name."""
        from cosmic_ray.mutating import mutate_code
        from cosmic_ray.plugins import get_operator

        source = mutate_code(self.path.read_text(encoding="utf-8"), get_operator(self.operator)(), self.occurrence)
        return Mutant(self.path, self.line, self.operator.removeprefix("core/"), source)


def places(path: Path, rng: random.Random) -> list[Place]:
    """All places in the file, with one change each."""
    from cosmic_ray.ast import ast_nodes, get_ast
    from cosmic_ray.plugins import get_operator, operator_names

    text = path.read_text(encoding="utf-8")
    nodes, unused = list(ast_nodes(get_ast(text))), without_effect(ast.parse(text))
    at: dict[tuple[int, int], list[tuple[str, int]]] = {}
    for name in operator_names():
        if get_operator(name).arguments():
            continue
        found = [start for node in nodes for start, _ in get_operator(name)().mutation_positions(node)]
        for occurrence, start in enumerate(found):
            if start not in unused:
                at.setdefault(start, []).append((name, occurrence))
    made = []
    for (line, _), choices in sorted(at.items()):
        place = Place(path, line, *rng.choice(choices))
        with contextlib.suppress(AttributeError):
            if place.operator == "core/ExceptionReplacer":
                place.mutant()
            made.append(place)
    return made


def changed(mutant: Mutant) -> str:
    """The first changed line."""
    both = zip_longest(mutant.path.read_text(encoding="utf-8").splitlines(), mutant.source.splitlines(), fillvalue="")
    return next((new.strip() for old, new in both if old != new), "")


def place_of(mutant: Mutant) -> str:
    """File, line and change of a mutant."""
    return f"{mutant.path.relative_to(ROOT)}:{mutant.line} {mutant.operator}: {changed(mutant)}"


def load(names: tuple[str, ...]) -> None:
    """Import the modules."""
    for name in names:
        import_module(name)


def examine(group: str, sample: int, seed: int, every: bool) -> tuple[int, list[Mutant]]:
    """Number of mutants tried and those that survived."""
    patterns, names = GROUPS[group]
    suite = Suite(ROOT, [f"tests/{name}" for name in names], [SLOW], frozenset(("palpate", "palpate_lab")))
    rng = random.Random(f"{seed} {group}")
    paths = sorted({path for pattern in patterns for path in ROOT.glob(pattern)})
    if group != "units":
        load(PRELOADED_BUT_FOR_UNITS)
    if early := [path for path in paths if str(path) in {getattr(one, "__file__", "") for one in sys.modules.values()}]:
        sys.exit(
            f"{group}: {early[0]} is loaded before it can be mutated. Mend: examine units first, or shorten PRELOADED"
        )
    made = [place for path in paths for place in places(path, rng)]
    begin = cpu_time()
    passed, lines = suite.map_lines(set(paths))
    if not passed:
        sys.exit(f"{group}: its tests fail without a mutant. Mend: run pytest on {' '.join(names)}")
    chosen = rng.sample(made, min(sample, len(made)))
    print(f"{group}: {len(chosen)} of {len(made)} places; {len(lines.tests)} tests, which take "
          f"{cpu_time() - begin:.1f} s of processor time under the tracer", flush=True)  # fmt: skip
    begin, survived = cpu_time(), []
    for mutant in (place.mutant() for place in chosen):
        if suite.survives(mutant, None if every else lines)[0]:
            survived.append(mutant)
            unseen = "" if lines.tests_of(mutant) else " (no test executes it)"
            print(f"  survived: {place_of(mutant)}{unseen}", flush=True)
    print(f"{group}: {(cpu_time() - begin) / len(chosen):.1f} s of processor time a mutant", flush=True)
    return len(chosen), survived


def main() -> None:
    """Print the score of each group."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("groups", nargs="*", default=list(GROUPS), help=f"groups to examine: {', '.join(GROUPS)}")
    parser.add_argument("--sample", type=int, default=40, help="places per group")
    parser.add_argument("--seed", type=int, default=0, help="seed of the sample")
    parser.add_argument("--every-test", action="store_true", help="run all tests of a group on each mutant (slow)")
    parser.add_argument("--json", type=Path, help="file for the number of mutants and the survivors")
    options = parser.parse_args()
    os.environ |= {"OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    os.chdir(ROOT)
    sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
    sys.dont_write_bytecode = True
    load(PRELOADED)
    start, tried, alive = time.monotonic(), 0, list[str]()
    for group in sorted(options.groups, key=list(GROUPS).index):
        n, survived = examine(group, options.sample, options.seed, options.every_test)
        tried, alive = tried + n, alive + [place_of(mutant) for mutant in survived]
        print(f"{group}: {n - len(survived)} of {n} killed, {(n - len(survived)) / n:.0%}", flush=True)
    killed = tried - len(alive)
    if options.json:
        options.json.write_text(json.dumps({"tried": tried, "survived": alive}), encoding="utf-8")
    print(f"{killed} of {tried} killed, {killed / tried:.0%}; {time.monotonic() - start:.0f} s, seed {options.seed}")


if __name__ == "__main__":
    main()
