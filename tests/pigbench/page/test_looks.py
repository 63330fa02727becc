import matplotlib.colors
import pytest

from pigbench.page.looks import DASHES, HATCHES, MARKERS, VARIANTS, look
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
    assert (luminance(look(method).shade.dark) + 0.05) / (luminance("#16181d") + 0.05) > 3


def test_methods_that_differ_by_day_differ_by_night():
    looks = {method: look(method) for method in styles.STYLES}
    assert len({(one.shade.dark, one.dash) for one in looks.values()}) == len(looks)


def test_every_style_has_its_look():
    assert DASHES.keys() == HATCHES.keys() == styles.HATCHES.keys()
    assert MARKERS.keys() - {"o"} == VARIANTS.keys() == styles.VARIANTS.keys()
    assert look("gcivl (full)").marker != look("gcivl").marker
    assert look("gcivl (full)").shade == look("gcivl").shade
