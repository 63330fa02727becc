"""Small regression studies of the paper: what a regulariser does to a cost-to-go that is known."""

from collections.abc import Mapping

from pigbench.toy.anisotropy import ANISOTROPY
from pigbench.toy.hybrid import HYBRID
from pigbench.toy.problem import Example

EXAMPLES: Mapping[str, Example] = {"hybrid": HYBRID, "anisotropy": ANISOTROPY}
