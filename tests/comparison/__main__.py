"""`python -m tests.comparison`: what `compare` says of the same code, of a slower kernel, of a worse result.

Figures into results/reference/comparison.json. Each run is a process of its own, as a user's two runs are.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from lodbench.datasets_gen.files import write_file
from lodbench.harness.cli.output import say
from lodbench.harness.record.environment import commit, now
from lodbench.harness.record.record import read_run
from lodbench.harness.report.compare import LEVEL, THRESHOLD, compare, confirm
from lodbench.harness.report.statistics import NOISY_OTHERS
from tests.comparison.changed import KERNEL, SHARE, SLOWER, WORSE

ROWS, ERRORS = (Path(__file__).with_name(name) for name in ("rows.toml", "errors.toml"))
RECORD = Path(__file__).parents[2] / "results/reference/comparison.json"
SAMPLES = 60  # of each row: long enough for what disturbs a shared machine to hit all runs alike
EVERY = 5  # runs of the same code from one that is changed to the next


def measured(folder, change="", rows=ROWS):
    """A run of these rows, of code that is changed so, that nothing disturbed; one that is there is not made again."""
    while not (folder / "samples.jsonl.gz").exists() or _disturbed(folder):
        shutil.rmtree(folder, ignore_errors=True)
        module = ["tests.comparison.changed", change] if change else ["lodbench.harness"]
        words = [sys.executable, "-m", *module, "sweep", str(rows), "--out", str(folder)]
        words += ["--samples", str(SAMPLES), "--quiet"]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    return read_run(folder)


def _disturbed(folder):
    return any(group.others > NOISY_OTHERS for group in read_run(folder).groups)


def judged(a, b, *again):
    """{system: why} of the rows of b that are called worse than in a, {system: times as long}, those called faster."""
    found = compare(a, b)
    confirm(found, [compare(a, one, THRESHOLD / 2) for one in again])
    rows = found["rows"]
    worse = {row["system"]: row["why"] for row in rows if row["verdict"] == "regression"}
    ratios = {row["system"]: row["ratio"] for row in rows}
    return worse, ratios, [row["system"] for row in rows if row["verdict"] == "faster"]


def record(folder, times):
    """Measure all of it, and say what was found."""
    none = {"tries": 0, "found": 0, "others": 0}
    found = {
        "same": {"comparisons": 0, "alarms": 0, "alarms_of_one_run": 0, "rows": 0, "called_faster": 0},
        "slower": {"share": SHARE, "kernel": KERNEL, "system": SLOWER, **none, "said": []},
        "worse": {"share": SHARE, "system": WORSE, **none, "said": []},
    }  # fmt: skip
    before = measured(folder / "same-0")
    for number in range(1, times + 1):
        run = measured(folder / f"same-{number}")
        worse, ratios, faster = judged(before, run)
        same = found["same"]
        same["comparisons"] += 1
        same["alarms_of_one_run"] += bool(worse)
        if worse:
            worse = judged(before, run, measured(folder / f"again-{number}"))[0]
        same["alarms"] += bool(worse)
        same["called_faster"] += bool(faster)
        same["rows"] = len(ratios)
        say(f"{number}: the same code: {worse or 'no alarm'}", err=True)
        if number % EVERY == 0:
            slower = [measured(folder / f"slower-{number}{x}", "slower") for x in ("", "-again")]
            _changed(found["slower"], run, *slower)
            right = measured(folder / f"right-{number}", rows=ERRORS)
            _changed(found["worse"], right, measured(folder / f"worse-{number}", "worse", ERRORS))
        before = run
    short, dirty = commit()
    machine = before.environment["machine"]["cpu"], before.environment["device"]["driver"]
    about = dict(zip(("cpu", "driver"), machine, strict=True))
    about |= {"level": LEVEL, "threshold": THRESHOLD, "commit": short, "dirty": dirty}
    return {**found, **about, "when": now()}


def _changed(one, right, *changed):
    """Count whether a defect is found where it was put in, and what else is called worse."""
    worse, ratios, _ = judged(right, *changed)
    why = worse.pop(one["system"], "")
    one["tries"] += 1
    one["found"] += ("slower" if "kernel" in one else "rms_error") in why
    one["others"] += len(worse)
    one["said"].append(f"{why}, {ratios[one['system']]:.3f} times as long")
    say(f"{one['system']} changed: {one['said'][-1]}; others: {worse or 'no alarm'}", err=True)


def main():
    """Measure, write the record, and end with 1 where `compare` was wrong more often than it may be."""
    options = argparse.ArgumentParser(prog="python -m tests.comparison", description=__doc__)
    options.add_argument("--times", type=int, default=20, help="comparisons of the same code")
    options.add_argument(
        "--runs", type=Path, help="a folder that keeps the runs, and may hold some"
    )
    options.add_argument("--out", type=Path, default=RECORD)
    given = options.parse_args()
    with tempfile.TemporaryDirectory(prefix="lodbench-comparison-") as folder:
        found = record(given.runs or Path(folder), given.times)
    write_file(given.out, json.dumps(found, indent=1, sort_keys=True) + "\n")
    lines = wrong(found)
    say("\n".join(lines) or f"as it should be: {given.out}")
    return 1 if lines else 0


def wrong(found):
    """What a record says that must not be."""
    same, lines = found["same"], []
    if same["alarms"] > found["level"] * same["comparisons"]:
        lines.append(
            f"{same['alarms']} alarms in {same['comparisons']} comparisons of the same code"
        )
    for change in ("slower", "worse"):
        one = found[change]
        if one["found"] < one["tries"]:
            lines.append(f"{change}: {one['found']} of {one['tries']} found")
    return lines


if __name__ == "__main__":
    sys.exit(main())
