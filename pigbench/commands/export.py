"""`pigbench export`: a trained policy to share."""

import dataclasses
from pathlib import Path

import tyro

from pigbench import envs
from pigbench.sharing import card
from pigbench.support import files


@dataclasses.dataclass(frozen=True)
class Export:
    """Write a run's policy to a folder from which it can act wherever JAX runs, without pigbench.

    The folder contains the parameters (safetensors), the configuration, the observation layout, an
    acting program (made by jax.export, for CPU, GPU and TPU) and a README with the lines to run it.
    """

    run_folder: tyro.conf.Positional[Path]
    """Folder of the run."""
    out: Path
    """Folder of the policy."""
    checkpoint: str = "last"
    """Policy: last, best, or that of a training step."""
    license: str = card.LICENSE
    """Licence of the policy, as named on the hub."""

    def run(self) -> None:
        """Write the folder."""
        from pigbench.runs.restore import restore
        from pigbench.sharing import policy

        files.require_folder(self.out)
        # Nothing is simulated: any engine does, and this machine may lack the run's own.
        trained = restore(self.run_folder, engine=envs.default_engine(), checkpoint=self.checkpoint)
        policy.write(self.out, trained, license=self.license)
        print(f"{self.out} contains the policy after {int(trained.state.step):,} updates")
