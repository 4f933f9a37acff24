"""One target in a process of its own: TARGET COUNT SEED; says each input before it is tried, and what came of it."""

import resource
import sys
import warnings

from hypothesis import HealthCheck, Phase, given, seed, settings

from lodbench.harness.cli.output import say
from tests.fuzz.inputs import written
from tests.fuzz.targets import outcome, target

MEMORY = 6 << 30  # bytes of address space: what promises more than there is must not get it


def main():
    name, count, first = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    found = target(name)
    say("ready")

    @seed(first)
    @settings(
        max_examples=count, deadline=None, database=None, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(found.strategy)
    def tried(description):
        say(f"try {written(description)}")
        say(f"did {outcome(found, description)}")

    tried()
    say("end")


main()
