"""`pigbench toy`: the effect of regularisers on a cost-to-go that is known in closed form."""

import dataclasses
import pkgutil
from pathlib import Path

from pigbench import devices
from pigbench.errors import lookup, require
from pigbench.provenance import surroundings
from pigbench.seeds import Seed, check
from pigbench.support import files
from pigbench.support.lock import only_writer
from pigbench.support.progress import Progress
from pigbench.toy import EXAMPLES
from pigbench.toy.settings import Settings


@dataclasses.dataclass(frozen=True)
class Toy:
    """Fit a known cost-to-go by plain regression and with the HJB and the Eikonal residual.

    Writes the figures `figure` and `extended` (png and pdf), the table `errors` (md and csv) and
    toy.json.
    """

    out: Path
    """Folder of the results."""
    example: str = "hybrid"
    """hybrid (an object that moves only when held) or anisotropy (speed depends on direction)."""
    seeds: int = 5
    """Number of seeds over which means and standard deviations are taken."""
    seed: Seed = 0
    """The first seed."""
    settings: Settings = dataclasses.field(default_factory=Settings)
    """Settings of the fits."""

    def __post_init__(self) -> None:
        lookup("example", EXAMPLES, self.example)
        require(self, lambda x: x >= 1, "at least 1", "seeds")
        check(self.seed + self.seeds - 1)

    def run(self) -> None:
        """Fit, print the table and write the files."""
        from pigbench.report import canvas
        from pigbench.toy import errors, figures
        from pigbench.toy.fit import LOSSES
        from pigbench.toy.study import study

        devices.backend()  # raises before a folder is made
        example = pkgutil.resolve_name(EXAMPLES[self.example])
        with only_writer(self.out):
            total = self.settings.steps * len(LOSSES) * len(example.fits)
            with Progress(f"toy {self.example}", total=total, unit="updates") as progress:
                outcomes = study(
                    example,
                    seeds=range(self.seed, self.seed + self.seeds),
                    settings=self.settings,
                    report=progress.advance,
                )
            found = errors.estimates(outcomes, self.settings)
            table = errors.markdown(found)
            print(table)
            files.write_text(self.out / "errors.md", table + "\n")
            files.write_text(self.out / "errors.csv", errors.comma_separated(found))
            with canvas.look(math=True):
                for name, draw in (("figure", figures.overview), ("extended", figures.extended)):
                    picture = draw(example, outcomes, self.settings)
                    for extension in ("png", "pdf"):
                        canvas.save(picture, self.out / f"{name}.{extension}")
            settings = {k: v for k, v in dataclasses.asdict(self).items() if k != "out"}
            files.write_json(self.out / "toy.json", {"settings": settings} | surroundings())
        print(f"wrote the table, the figures and the settings to {self.out}")
