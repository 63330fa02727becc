"""Small regression studies, one of them the paper's, of a regulariser and a known cost-to-go."""

from collections.abc import Mapping

from pigbench.toy.anisotropy import ANISOTROPY
from pigbench.toy.hybrid import HYBRID
from pigbench.toy.problem import Example

EXAMPLES: Mapping[str, Example] = {"hybrid": HYBRID, "anisotropy": ANISOTROPY}
