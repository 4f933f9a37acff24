"""What a claim is: a sentence of a paper, and the recorded figures that must hold for it to be true."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Reach = Literal["every", "one"]
"""Which of the cases must hold: "every", or "one", the best, where a source says "up to"."""


@dataclass(frozen=True)
class Pick:
    """The subjects that a claim speaks of: a system, with these parameters whatever the others are, but not with those.

    Attributes:
        system: its name.
        params: that it has.
        without: that it does not have, such as what is ours and not the paper's.
    """

    system: str
    params: Mapping[str, Any] = field(default_factory=dict)
    without: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        words = [self.system, *(f"{key}={value}" for key, value in self.params.items())]
        return " ".join(words)


@dataclass(frozen=True)
class Comparison:
    """How many times `subject` is ahead of `other`, in every group that has both.

    A pair has the same values of all other parameters that both have, and like numbers of triangles where these were
    asked for.

    Attributes:
        what: "faster", samples; "frames faster", whole frames that were drawn; "closer", RMS error; or a count.
        least, most: the ratio that the claim allows; one of them.
        table: the groups of this table alone; None those of all.
        facts: the groups that have these facts alone.
        stage: the device's seconds in this stage in place of samples, where "faster".
    """

    subject: Pick
    other: Pick
    what: Literal[
        "faster",
        "frames faster",
        "closer",
        "fewer triangles",
        "fewer KSQuads",
        "fewer stored vertices",
    ] = "faster"
    least: float | None = None
    most: float | None = None
    reach: Reach = "every"
    table: str | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)
    stage: str = ""

    def __str__(self) -> str:
        return f"both {self.subject} and {self.other}"


@dataclass(frozen=True)
class Rows:
    """A number that stands in a table's rows, with its interval where it was sampled.

    Attributes:
        table, column: where it stands.
        where: column -> its value, or a tuple of such, or a pattern such as "dabt_*": which rows.
        says: what follows the number, such as "of the nodes collide".
        least, most: what the claim allows; one of them, or both.
    """

    table: str
    column: str
    where: Mapping[str, Any]
    says: str
    least: float | None = None
    most: float | None = None
    reach: Reach = "every"

    def __str__(self) -> str:
        return f"{self.column} of table {self.table}"


@dataclass(frozen=True)
class Share:
    """The share of a subject's device time that some of its stages take, sample by sample.

    Attributes:
        stages: of which the share is; subjects without one of them do not count.
        says: what follows the number.
        least, most: the share that the claim allows; one of them, or both.
    """

    subject: Pick
    stages: tuple[str, ...]
    says: str
    least: float | None = None
    most: float | None = None
    reach: Reach = "every"

    def __str__(self) -> str:
        return f"stages {', '.join(self.stages)} of {self.subject}"


Evidence = Comparison | Rows | Share


@dataclass(frozen=True)
class Claim:
    """One claim.

    Attributes:
        name: short, unique; it begins with the paper's.
        text: what is claimed.
        source: paper, section.
        evidence: all of it must hold; none where nothing that is recorded could decide.
        published: the value that the source gives; None where it gives none or it was not at hand.
        note: in what the measurement here differs from the paper's.
        not_on_cpu: why no run on a CPU can decide it; "" where one can.
    """

    name: str
    text: str
    source: str
    evidence: tuple[Evidence, ...] = ()
    published: str | None = None
    note: str = ""
    not_on_cpu: str = ""
