import itertools

import numpy as np

from pigbench.report import styles


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


def test_an_unknown_method_keeps_its_style():
    assert styles.style("mine") == styles.style("mine")
    # CRC-32 of "123456789" is the published check value 0xCBF43926, which is 6 modulo 8.
    assert styles.style("123456789").color == styles.VERMILLION


def test_variants_share_colour_and_line_with_their_method():
    plain = styles.style("h-flow-qrl")
    variants = [styles.style(f"h-flow-qrl ({name})") for name in ("full", "joints-contacts")]
    assert {(look.color, look.line) for look in variants} == {(plain.color, plain.line)}
    assert len({look.marker for look in (plain, *variants)}) == 3
    assert len({look.hatch for look in (plain, *variants)}) == 3
