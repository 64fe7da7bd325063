# SPDX-License-Identifier: Apache-2.0
"""The directory of a run: the names of its files and folders."""

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from zlib import crc32

from rocsafe_geo.storage.durable import PART_SUFFIX
from rocsafe_orchestrator.errors import SetupError

# Folder of the user's own procedures.
PROCEDURES = 'procedures'


@dataclass(frozen=True, slots=True)
class RunDirectory:
    """Paths of the files and folders of a run below `path`."""

    path: Path

    @property
    def name(self) -> str:
        """Name of the folder, which is also the mission's id."""
        return self.path.name

    @property
    def scenario(self) -> Path:
        """The scenario as flown, with every default written out."""
        return self.path / 'scenario.yaml'

    @property
    def run_info(self) -> Path:
        """Command, versions, git revision and, once it is known, the outcome."""
        return self.path / 'run.json'

    @property
    def parameters(self) -> Path:
        """Folder of the parameter files, one a process."""
        return self.path / 'params'

    @property
    def logs(self) -> Path:
        """Folder of the output of each process."""
        return self.path / 'logs'

    @property
    def spool(self) -> Path:
        """Folder in which simulated vehicles keep data until it is received."""
        return self.path / 'spool'

    @property
    def hazard(self) -> Path:
        """Folder of sources and dose map as they are known during the mission."""
        return self.spool / 'hazard'

    @property
    def drives(self) -> Path:
        """Folder of the drive of a ground vehicle."""
        return self.path / 'ground'

    @property
    def images(self) -> Path:
        """Image store."""
        return self.path / 'images'

    @property
    def mosaic(self) -> Path:
        """Georeferenced map."""
        return self.path / 'mosaic.tif'

    @property
    def plan(self) -> Path:
        """Plan as the planner wrote it."""
        return self.path / 'plan.json'

    @property
    def further_plans(self) -> list[Path]:
        """Plans made during the flight: for the rest of a survey, or for another round."""
        return sorted(self.path.glob('further-*/plan.json'))

    @property
    def recording(self) -> Path:
        """All messages of the run."""
        return self.path / 'mission.mcap'

    @property
    def readings(self) -> Path:
        """Table of all dose-rate readings."""
        return self.path / 'readings.csv'

    @property
    def summary(self) -> Path:
        """Figures of the run as JSON."""
        return self.path / 'summary.json'

    @property
    def report(self) -> Path:
        """Report of the run as HTML."""
        return self.path / 'report.html'

    @property
    def session(self) -> Path:
        """What a resumed run needs to find its processes; there until the run is over."""
        return self.path / 'session.json'

    @property
    def flown(self) -> Path:
        """Empty file that is there once all of a run is recorded."""
        return self.spool / 'flown'

    @property
    def lock(self) -> Path:
        """File that the process which flies the run keeps locked."""
        return self.path / 'run.lock'

    @property
    def agents_lock(self) -> Path:
        """File that the agents of the vehicles keep locked."""
        return self.path / 'agents.lock'

    @property
    def photographs_token(self) -> Path:
        """File with the token by which other hosts hand over photographs."""
        return self.path / 'photographs.token'

    def log_of(self, process: str) -> Path:
        """Return the log file of `process`."""
        return self.logs / f'{process}.log'

    def solids_of(self, scene: str) -> Path:
        """Return the file of the solid things and the ground of the scene file `scene`."""
        return self.parameters / f'{Path(scene).stem}-{crc32(scene.encode()):08x}.npz'

    @property
    def site_wind(self) -> Path:
        """How the scene of ``air.wind`` changes the wind."""
        return self.parameters / 'site-wind.npz'

    def parameters_of(self, process: str) -> Path:
        """Return the parameter file of `process`."""
        return self.parameters / f'{process}.yaml'


def run_name(scenario: str, now: datetime) -> str:
    """Return the name of a run that begins now: ``<scenario>-<YYYYMMDD-HHMMSS>``."""
    return f'{scenario}-{now:%Y%m%d-%H%M%S}'


def create_run_directory(parent: Path, stem: str) -> RunDirectory:
    """Make a new folder `stem` below `parent`; two runs of the same name get different folders.

    Raises
    ------
    SetupError
        If the folder cannot be made.
    """
    for suffix in ('', *(f'-{number}' for number in range(2, 100))):
        try:
            (parent / (stem + suffix)).mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            raise SetupError(f'{parent}: cannot make a run directory: {error.strerror}') from error
        return _filled(RunDirectory((parent / (stem + suffix)).resolve()))
    raise SetupError(f'{parent}: too many runs named {stem}')


def _filled(run: RunDirectory) -> RunDirectory:
    for folder in (run.parameters, run.logs, run.spool, run.images):
        folder.mkdir()
    return run


def remove_parts(run: RunDirectory) -> None:
    """Remove what a process that was killed has left half written; none may be running."""
    for part in run.path.glob(f'*{PART_SUFFIX}'):
        part.unlink(missing_ok=True)
