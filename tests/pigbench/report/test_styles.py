import itertools

import numpy as np
import pytest

from pigbench.report import styles

OWN = ["huber-bc", "lipschitz-gcivl", "positive-gcivl", "h-flow-lipschitz-gcivl", "mine"]


def rgb(color):
    return np.array([int(color[start : start + 2], 16) for start in (1, 3, 5)])


def test_methods_can_be_told_apart():
    assert len(set(styles.STYLES.values())) == len(styles.STYLES)
    looks = {(look.color, look.hatch) for look in styles.STYLES.values()}
    assert len(looks) == len(styles.STYLES)
    for first, second in itertools.combinations(styles.PALETTE, 2):
        assert np.abs(rgb(first) - rgb(second)).sum() > 60


def test_colours_stand_out_on_white():
    # Contrast by the Web Content Accessibility Guidelines' definition of luminance.
    def luminance(color):
        linear = ((rgb(color) / 255 + 0.055) / 1.055) ** 2.4
        return linear @ [0.2126, 0.7152, 0.0722]

    assert all(1.05 / (luminance(color) + 0.05) > 2 for color in styles.PALETTE)


def test_methods_of_pigbench_keep_their_styles_whatever_is_drawn_with_them():
    assert styles.styles([*OWN, *styles.STYLES]).items() >= styles.STYLES.items()
    assert styles.styles(["crl"]) == {"crl": styles.STYLES["crl"]}


@pytest.mark.parametrize(
    "methods",
    [
        [*OWN, *styles.STYLES],
        ["lipschitz-gcivl", "crl", "huber-bc", "positive-gcivl"],  # of the same CRC modulo 8
        [f"method-{number}" for number in range(40)],
        ["h-flow-gcivl", "gcivl", *(f"h-flow-gcivl ({number})" for number in range(20))],
        [f"{name} ({variant})" for name in ("gcivl", "h-flow-gcivl", "mine") for variant in "abcd"],
    ],
)
def test_no_two_of_what_is_drawn_together_look_alike(methods):
    looks = styles.styles(methods)
    assert looks.keys() >= set(methods)
    assert len({*looks.values()}) == len(looks)
    assert len({(look.color, look.hatch) for look in looks.values()}) == len(looks)
    assert styles.styles(reversed(methods)) == looks


def test_an_unknown_method_keeps_its_style_beside_others():
    alone = styles.styles(["mine"])["mine"]
    assert styles.styles(["mine", *styles.STYLES])["mine"] == alone
    assert alone not in styles.STYLES.values()
    assert alone.marker == "o"


def test_variants_share_colour_and_line_with_their_method():
    names = ["h-flow-qrl", *(f"h-flow-qrl ({name})" for name in ("full", "joints-contacts"))]
    plain, *variants = (styles.styles(names)[name] for name in names)
    assert {(look.color, look.line) for look in variants} == {(plain.color, plain.line)}
    assert len({look.marker for look in (plain, *variants)}) == 3
    assert len({look.hatch for look in (plain, *variants)}) == 3
