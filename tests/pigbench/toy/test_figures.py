import numpy as np
import pytest

from pigbench.toy import figures
from pigbench.toy.hybrid import HYBRID
from pigbench.toy.settings import Settings
from pigbench.toy.study import SIDE, ToyOutcome

SETTINGS = Settings(half_width=2.0)
OFFSETS = {"baseline": 0.0, "hjb": 0.25, "eikonal": -0.5}


@pytest.fixture
def outcomes():
    """Fits that differ from d* by a constant: 0.1 more and 0.1 less in the two seeds."""
    positions = np.linspace(-2, 2, SIDE)
    agents, objects = np.meshgrid(positions, positions)
    free = np.abs(agents - objects) + 1 + np.abs(objects)
    surfaces = [free, np.abs(agents)]
    sections = [np.abs(1 - positions) + 1 + np.abs(positions), np.abs(positions)]
    seeds = np.array([[0.1], [-0.1]])
    return [
        ToyOutcome(mode, loss, surface.ravel() + offset + seeds, section + offset + seeds)
        for mode, surface, section in zip(HYBRID.fits[0], surfaces, sections, strict=True)
        for loss, offset in OFFSETS.items()
    ]


def test_the_overview_shows_truth_fits_and_sections(outcomes):
    figure = figures.overview(HYBRID, outcomes, SETTINGS)
    panels = [panel for panel in figure.axes if panel.get_title()]
    assert [panel.get_title() for panel in panels[:5]] == [
        "$d^*$, no contact",
        "Baseline, no contact",
        "HJB, no contact",
        "Eikonal, no contact",
        "no contact",
    ]
    truth, *_, eikonal = (panel.images[0].get_array() for panel in panels[:4])
    assert truth[0, 0] == pytest.approx(3.0)  # agent and object at -2
    assert truth[0, -1] == pytest.approx(7.0)  # agent at 2, object at -2
    np.testing.assert_allclose(eikonal, truth - 0.5, atol=1e-5)
    lines = {line.get_label(): line for line in panels[4].lines}
    colors = {label: line.get_color() for label, line in lines.items()}
    assert colors == {
        "$d^*$": "#000000",
        "Baseline": "#0072B2",
        "HJB": "#D55E00",
        "Eikonal": "#E69F00",
    }
    shift = lines["HJB"].get_ydata() - lines["$d^*$"].get_ydata()
    np.testing.assert_allclose(shift, 0.25, atol=1e-5)
    assert panels[4].get_xlabel() == "object $x_o$ (agent at 1)"


def test_the_extended_figure_shows_fits_and_errors_on_one_scale_a_row(outcomes):
    figure = figures.extended(HYBRID, outcomes, SETTINGS)
    panels = [panel for panel in figure.axes if panel.get_title()]
    assert len(panels) == 4 * 3
    errors = [panel.images[0] for panel in panels[9:]]
    for image, offset in zip(errors, OFFSETS.values(), strict=True):
        np.testing.assert_allclose(image.get_array(), offset, atol=1e-5)
        assert image.get_clim() == pytest.approx((-0.5, 0.5), abs=1e-5)
