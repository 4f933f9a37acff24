"""`python -m tests.fuzz`: everything that may go wrong, tried; figures into results/reference/faults.json."""

import argparse
import json
import signal
import sys
from pathlib import Path

from lodbench.datasets_gen.files import write_file
from lodbench.harness.cli.output import say
from lodbench.harness.record.environment import commit, now
from tests.fuzz import devices, faults, targets
from tests.fuzz.fuzz import LIMIT_S, fuzz

AT_ONCE = 10  # runs that are stopped, between two looks at what came of them
RECORD = Path(__file__).parents[2] / "results/reference/faults.json"
COUNTS = ("tries", "ok", "refused", "while_running", "kernels")


def options():
    found = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    found.add_argument("--inputs", type=int, default=10_000, help="per system and reader")
    found.add_argument("--stops", type=int, default=100, help="runs killed, and runs interrupted")
    found.add_argument("--seed", type=int, default=0)
    found.add_argument("--only", nargs="*", default=[], help="of these systems, readers, faults")
    found.add_argument("--resume", action="store_true", help="count what the record has already")
    found.add_argument("--out", type=Path, default=RECORD)
    return found.parse_args()


class Record:
    """The file of figures, written anew after each part of them."""

    def __init__(self, path, resume):
        self.path, self.resume, self.lost = path, resume, {}
        self.found = json.loads(path.read_text("utf-8")) if path.exists() else {}
        self.commit, self.dirty = commit()

    def before(self, kind, name):
        """What there is of this already, where that counts."""
        return self.found.get(kind, {}).get(name, {}) if self.resume else {}

    def keep(self, kind, name, result, before=None):
        """Write a result down, with every commit that has a share in it."""
        commits = [one for one in (before or {}).get("commit", "").split(", ") if one]
        about = {"commit": ", ".join(dict.fromkeys([*commits, self.commit])), "when": now()}
        about["dirty"] = self.dirty or (before or {}).get("dirty", False)
        self.found.setdefault(kind, {})[name] = {**result, **about}
        self.lost[name] = len(result["losses"])
        write_file(self.path, json.dumps(self.found, indent=1, sort_keys=True) + "\n")

    def tell(self, kind, name):
        result = self.found[kind][name]
        said = ", ".join(f"{result[key]:,} {key}" for key in COUNTS if key in result)
        say(f"{kind}: {name}: {said}, {self.lost[name]} lost {result.get('skipped', '')}".strip())


def fed(record, kind, name, given):
    """Damaged inputs for a system or a reader."""
    before = record.before(kind, name)
    if before.get("tries", 0) < given.inputs:
        counts = {
            key: before[key] for key in ("tries", "ok", "refused", "losses", "seconds") if before
        }
        fuzz(
            name, given.inputs, given.seed, LIMIT_S, lambda text: say(text, err=True), before=counts,
            keep=lambda result: record.keep(kind, name, {**result, "seed": given.seed}, before),
        )  # fmt: skip
        record.tell(kind, name)


def stopped(record, name, number, given):
    """Runs that get a signal, `AT_ONCE` at a time."""
    before = record.before("faults", name)
    counts = ("tries", "while_running", "losses")
    found = (
        {key: before[key] for key in counts}
        if before
        else dict(zip(counts, (0, 0, []), strict=True))
    )
    while found["tries"] < given.stops:
        more = min(AT_ONCE, given.stops - found["tries"])
        part = faults.stopped(more, number, given.seed + found["tries"])
        found = {key: found[key] + part[key] for key in counts}
        record.keep("faults", name, found, before)
        record.tell("faults", name)


def main():
    """Try it, write what came of it after each part, and end with 1 where something was lost."""
    given = options()
    record = Record(given.out, given.resume)
    ways = {
        name: lambda name=name, kind=kind: fed(record, kind, name, given)
        for kind, names in zip(("systems", "readers"), targets.names(), strict=True)
        for name in names
    }
    for name, number in (("killed", signal.SIGKILL), ("interrupted", signal.SIGINT)):
        ways[name] = lambda name=name, number=number: stopped(record, name, number, given)

    def once(name, what):
        record.keep("faults", name, what())
        record.tell("faults", name)

    for what in (
        faults.full_disk, faults.read_only, faults.peers,
        devices.broken_kernels, devices.little_memory, devices.oclgrind,
    ):  # fmt: skip
        ways[what.__name__] = lambda what=what: once(what.__name__, what)
    for name, try_it in ways.items():
        if not given.only or name in given.only:
            try_it()
    say(f"{sum(record.lost.values())} lost: {given.out}")
    return 1 if any(record.lost.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
