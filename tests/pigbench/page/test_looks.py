import matplotlib.colors
import pytest

from pigbench.page.looks import DASHES, GLYPHS, HATCHES, MARKERS, VARIANTS, looks
from pigbench.report import styles


def luminance(colour: str) -> float:
    """Of WCAG 2.2: what contrast is reckoned from."""
    linear = [
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in matplotlib.colors.to_rgb(colour)
    ]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


@pytest.mark.parametrize("method", styles.STYLES)
def test_lines_can_be_told_from_a_dark_ground(method):
    assert (luminance(looks([method])[method].shade.dark) + 0.05) / (
        luminance("#16181d") + 0.05
    ) > 3


def test_methods_that_differ_by_day_differ_by_night():
    shown = looks(styles.STYLES)
    assert len({(one.shade.dark, one.dash) for one in shown.values()}) == len(shown)


def test_bars_and_the_legend_tell_methods_apart():
    shown = looks(
        ["mine", *styles.STYLES]
        + [f"{name} ({variant})" for name in ("gcivl", "h-flow-gcivl") for variant in "abc"]
    )
    assert len({(one.shade, one.hatch) for one in shown.values()}) == len(shown)
    assert len({(one.shade, one.dash, one.glyph) for one in shown.values()}) == len(shown)


def test_every_style_has_its_look():
    assert DASHES.keys() == HATCHES.keys() == styles.HATCHES.keys()
    assert MARKERS.keys() - {"o"} == VARIANTS.keys() == styles.VARIANTS.keys()
    assert GLYPHS.keys() == MARKERS.keys()
    shown = looks(["gcivl", "gcivl (full)"])
    assert shown["gcivl (full)"].marker != shown["gcivl"].marker
    assert shown["gcivl (full)"].shade == shown["gcivl"].shade
