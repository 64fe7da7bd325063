# SPDX-License-Identifier: Apache-2.0
"""Names of all files and folders of a set-up."""

import re
from dataclasses import dataclass
from pathlib import Path

from workspace.errors import SetupError

# colcon, CMake and shebang lines cannot be relied on beyond these.
_UNSAFE_CHARACTER = re.compile(r'[^\w./+@,=~-]')


@dataclass(frozen=True)
class Layout:
    """Everything set-up reads and writes, below the `root` of one checkout."""

    root: Path

    def __post_init__(self) -> None:
        unsafe = _UNSAFE_CHARACTER.search(str(self.root))
        if unsafe:
            raise SetupError(
                f'the folder {str(self.root)!r} has {unsafe.group()!r} in its path, which the '
                'build tools cannot handle: move the checkout to a path of plain letters'
            )

    @property
    def venv(self) -> Path:
        """Virtual environment with everything that pip installs."""
        return self.root / '.venv'

    @property
    def python(self) -> Path:
        """Python of the virtual environment."""
        return self.venv / 'bin' / 'python'

    @property
    def environment_script(self) -> Path:
        """Shell script with the environment of the built workspace."""
        return self.venv / 'workspace.sh'

    @property
    def venv_record(self) -> Path:
        """Written when the virtual environment and its packages are complete."""
        return self.venv / 'rocsafe.json'

    @property
    def build(self) -> Path:
        """Build folder of colcon."""
        return self.root / 'build'

    @property
    def install(self) -> Path:
        """Install folder of colcon."""
        return self.root / 'install'

    @property
    def build_records(self) -> tuple[Path, Path]:
        """Written when the build is complete; in both folders, as either may be removed."""
        return self.build / 'rocsafe.json', self.install / 'rocsafe.json'

    @property
    def logs(self) -> Path:
        """Output of the commands that set-up runs."""
        return self.root / 'log' / 'setup'

    @property
    def ros_logs(self) -> Path:
        """Logs of nodes that are started by hand."""
        return self.root / 'log' / 'ros'

    @property
    def cache(self) -> Path:
        """Caches and temporary files of the tools; without it they go to the home folder."""
        return self.root / '.cache'

    @property
    def lock(self) -> Path:
        """Lock file of the set-up that runs in this checkout."""
        return self.cache / 'setup.lock'

    @property
    def requirements(self) -> Path:
        """Pinned packages."""
        return self.root / 'requirements'

    @property
    def sources(self) -> Path:
        """Packages of the suite."""
        return self.root / 'src'

    @property
    def planner(self) -> Path:
        """Package with the loops that are compiled ahead of their first use."""
        return self.sources / 'rocsafe_planner'

    @property
    def kernels(self) -> list[Path]:
        """Sources of those loops."""
        return sorted((self.planner / 'rocsafe_planner/solver').rglob('*.py'))
