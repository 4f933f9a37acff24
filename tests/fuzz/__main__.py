"""`python -m tests.fuzz`: everything that may go wrong, tried; figures into results/reference/faults.json."""

import argparse
import json
import signal
import sys
from pathlib import Path

from lodbench.datasets_gen.files import write_file
from lodbench.harness.cli.output import say
from lodbench.harness.record.environment import commit, now
from tests.fuzz import faults, targets
from tests.fuzz.fuzz import LIMIT_S, fuzz

AT_ONCE = 10  # runs that are stopped, between two looks at what came of them
RECORD = Path(__file__).parents[2] / "results/reference/faults.json"


def main():
    """Try it, write what came of it after each target, and end with 1 where something was lost."""
    options = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    options.add_argument("--inputs", type=int, default=10_000, help="per system and reader")
    options.add_argument("--stops", type=int, default=100, help="runs killed, and runs interrupted")
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--only", nargs="*", default=[], help="of these systems, readers, faults")
    options.add_argument("--out", type=Path, default=RECORD)
    given = options.parse_args()
    record = json.loads(given.out.read_text("utf-8")) if given.out.exists() else {}
    short, dirty = commit()
    lost = {}

    def keep(kind, name, result):
        lost[name] = len(result["losses"])
        about = {"commit": short, "dirty": dirty, "when": now()}
        record.setdefault(kind, {})[name] = {**result, **about}
        write_file(given.out, json.dumps(record, indent=1, sort_keys=True) + "\n")
        said = ", ".join(
            f"{v:,} {k}" for k, v in result.items() if isinstance(v, int) and k != "seed"
        )
        say(
            f"{kind}: {name}: {said}, {len(result['losses'])} lost {result.get('skipped', '')}".strip()
        )

    for kind, names in zip(("systems", "readers"), targets.names(), strict=True):
        for name in names:
            if not given.only or name in given.only:
                found = fuzz(
                    name, given.inputs, given.seed, LIMIT_S, lambda text: say(text, err=True)
                )
                keep(kind, name, {**found, "seed": given.seed})
    for name, number in (("killed", signal.SIGKILL), ("interrupted", signal.SIGINT)):
        if not given.only or name in given.only:
            found = {"tries": 0, "while_running": 0, "losses": []}
            while (
                found["tries"] < given.stops
            ):  # written down now and then: all of them take an hour
                more = min(AT_ONCE, given.stops - found["tries"])
                part = faults.stopped(more, number, given.seed + found["tries"])
                found = {key: found[key] + part[key] for key in found}
                keep("faults", name, found)
    tried = {
        "full_disk": faults.full_disk,
        "read_only": faults.read_only,
        "peers": faults.peers,
        "broken_kernels": faults.broken_kernels,
        "little_memory": faults.little_memory,
    }
    for name, what in tried.items():
        if not given.only or name in given.only:
            keep("faults", name, what())
    say(f"{sum(lost.values())} lost: {given.out}")
    return 1 if any(lost.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
