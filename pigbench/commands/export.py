"""`pigbench export`: a trained policy to share."""

import dataclasses
from pathlib import Path

import tyro

from pigbench.sharing import card, policy
from pigbench.support import files
from pigbench.training.restore import restore


@dataclasses.dataclass(frozen=True)
class Export:
    """Write a run's policy as a folder that acts wherever JAX runs, without pigbench.

    It holds the parameters (safetensors), the configuration, the observation layout, a program
    that acts (made by jax.export, for CPU, GPU and TPU) and a README with the lines that run it.
    """

    run_folder: tyro.conf.Positional[Path]
    """Folder of the run."""
    out: Path
    """Folder of the policy."""
    checkpoint: str = "last"
    """Which policy: last, best, or that of a training step."""
    license: str = card.LICENSE
    """Licence of the policy, by its name on the hub."""

    def run(self) -> None:
        """Write the folder."""
        files.require_folder(self.out)
        trained = restore(self.run_folder, checkpoint=self.checkpoint)
        policy.write(self.out, trained, license=self.license)
        print(f"{self.out} holds the policy after {int(trained.state.step):,} updates")
