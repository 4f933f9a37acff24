"""What the papers claim, as data: what is compared, and how it must come out. `report/claims.py` has the verdicts.

A claim is a sentence of a paper in our words, the published value where it is known, and what must hold in a run's
records. A new paper is a file like those beside this one, and needs no code.
"""

from lodbench.harness.claims.boubekeur import GEMS3, GMR05
from lodbench.harness.claims.concheiro import RC13
from lodbench.harness.claims.decoro import DT07
from lodbench.harness.claims.model import Claim, Comparison, Evidence, Pick, Rows, Share
from lodbench.harness.claims.wang import W14

__all__ = ["CLAIMS", "Claim", "Comparison", "Evidence", "Pick", "Rows", "Share"]

CLAIMS: tuple[Claim, ...] = (*GMR05, *GEMS3, *DT07, *RC13, *W14)
