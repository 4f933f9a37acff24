"""How many tests passed on which driver: `pytest --tally results/reference/runtimes.json`."""

import json
import time

from lodbench.datasets_gen.files import write_file
from lodbench.harness.record.environment import commit, now
from lodbench.kernels.opencl import Device

START = time.time()


def write(path, reporter):
    """Put the counts of a run of the suite beside those of other drivers, under the driver's name."""
    facts = Device.open().facts
    short, dirty = commit()
    failed = reporter.stats.get("failed", []) + reporter.stats.get("error", [])
    skipped = [report.longrepr[2] for report in reporter.stats.get("skipped", [])]
    record = json.loads(path.read_text("utf-8")) if path.exists() else {}
    record[f"{facts.platform} {facts.driver.split('driver ')[-1]}"] = {
        "device": facts.name,
        "passed": len(reporter.stats.get("passed", [])),
        "skipped": {reason: skipped.count(reason) for reason in sorted(set(skipped))},
        "failed": sorted({report.nodeid for report in failed}),
        "seconds": round(time.time() - START),
        "commit": short,
        "dirty": dirty,
        "when": now(),
    }
    write_file(path, json.dumps(record, indent=1, sort_keys=True) + "\n")
