"""Small regression studies, one of them the paper's, of a regulariser and a known cost-to-go."""

EXAMPLES = {
    "hybrid": "pigbench.toy.hybrid:HYBRID",
    "anisotropy": "pigbench.toy.anisotropy:ANISOTROPY",
}
"""Where each `Example` is, for `pkgutil.resolve_name`."""
