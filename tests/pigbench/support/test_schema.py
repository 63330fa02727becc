"""The reading of dataclasses from what JSON and TOML have."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal

import pytest

from pigbench.errors import UserError
from pigbench.support import schema


@dataclass(frozen=True)
class Point:
    x: float
    y: float = 0.0


@dataclass(frozen=True)
class Named(Point):
    name: str = ""


@dataclass(frozen=True)
class Circle:
    kind: Literal["circle"] = "circle"
    radius: float = 1.0

    def __post_init__(self) -> None:
        if self.radius <= 0:
            raise UserError(f"radius is {self.radius}: it must be positive")


@dataclass(frozen=True)
class Square:
    kind: Literal["square"] = "square"
    side: float = 2.0
    corner: Point = Point(0.0)


@dataclass(frozen=True)
class Drawing:
    origin: Point
    shape: Annotated[Circle | Square, schema.BY_KIND] = Circle()
    sizes: tuple[int, ...] = ()
    counts: int | Mapping[str, tuple[int, ...]] = 1
    more: Mapping[str, Any] = field(default_factory=dict)


@pytest.mark.parametrize(
    ("values", "drawing"),
    [
        ({"origin": {"x": 1}}, Drawing(Point(1.0))),
        (
            {"origin": {"x": 1, "y": 2}, "sizes": [3, 4], "counts": {"a": [5]}, "more": {"b": [6]}},
            Drawing(Point(1, 2), Circle(), (3, 4), {"a": (5,)}, {"b": [6]}),
        ),
        (
            {"origin": {"x": 0}, "shape": {"kind": "square", "corner": {"x": 7}}},
            Drawing(Point(0), Square(corner=Point(7))),
        ),
    ],
)
def test_read(values, drawing):
    assert schema.read(Drawing, values, "d.json") == drawing


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"origin": {}}, "origin.x: this field is missing"),
        ({"orgin": {}}, "orgin: there is no such field"),
        ({"origin": {"x": 0, "z": 1}}, "origin.z: there is no such field"),
        ({"origin": {"x": "far"}}, "origin.x: Input should be a valid number, .*, not 'far'"),
        ({"origin": 3}, "origin: 3 is no set of fields"),
        ({"sizes": [1, 2.5]}, "sizes.1: Input should be a valid integer, .*, not 2.5"),
        ({"counts": "many"}, "counts: Input should be a valid integer, .*, not 'many'"),
        ({"shape": {"kind": "star"}}, "shape: kind is 'star': known are 'circle', 'square'"),
        ({"shape": {"side": 1}}, "shape: its field kind is missing"),
        ({"shape": {"kind": "square", "corner": {}}}, "shape.corner.x: this field is missing"),
        ({"shape": {"kind": "circle", "side": 3}}, "shape.side: there is no such field"),
        ({"shape": {"kind": "circle", "radius": 0}}, "radius is 0.0: it must be positive"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(change, complaint):
    with pytest.raises(UserError, match=f"^d.json: {complaint}$"):
        schema.read(Drawing, {"origin": {"x": 0}} | change, "d.json")
    with pytest.raises(UserError, match=r"^d.json: \[\] is no set of fields$"):
        schema.read(Drawing, [], "d.json")


def test_a_template_is_filled_whatever_the_classes_of_its_parts():
    template = Drawing(Named(1, 2, "here"), Square(side=3, corner=Point(4, 5)))
    assert schema.fill(template, {}, "d.json") == template
    values = {"origin": {"y": 9}, "shape": {"corner": {"x": 8}}}
    assert schema.fill(template, values, "d.json") == Drawing(
        Named(1, 9, "here"), Square(side=3, corner=Point(8, 5))
    )
    other = {"shape": {"kind": "circle", "radius": 6}}
    assert schema.fill(template, other, "d.json") == replace(template, shape=Circle(radius=6))
    with pytest.raises(UserError, match=r"^d.json: origin: nam: there is no such field$"):
        schema.fill(template, {"origin": {"nam": "there"}}, "d.json")
