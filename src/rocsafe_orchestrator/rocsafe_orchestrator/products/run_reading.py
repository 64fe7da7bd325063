# SPDX-License-Identifier: Apache-2.0
"""Reader of a run directory, complete or not."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import rasterio
from rasterio.errors import RasterioError

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.products.flight_log import read_flight_log
from rocsafe_orchestrator.products.photographs import read_photographs
from rocsafe_orchestrator.products.run_record import FlightLog, Photograph, RunRecord
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario

T = TypeVar('T')


def read_run(directory: Path) -> RunRecord:
    """Read the run in `directory`; missing parts are listed, not refused."""
    return _Reading(RunDirectory(directory)).read()


class _Reading:
    """Reads the files of a run and lists what is missing."""

    def __init__(self, run: RunDirectory) -> None:
        self._run = run
        self._missing: list[str] = []

    def read(self) -> RunRecord:
        info = self._file(self._run.run_info, 'facts of the run', _json_object) or {}
        scenario: Scenario | None = self._file(self._run.scenario, 'scenario', read_scenario)
        log: FlightLog | None = self._file(self._run.recording, 'recording', read_flight_log)
        plan: SurveyPlan | None = self._file(self._run.plan, 'plan', _plan)
        photographs = read_photographs(self._run.images)
        self._check(plan, log, photographs)
        return RunRecord(
            path=self._run.path,
            info=info,
            scenario=scenario,
            plan=plan,
            log=log,
            photographs=photographs,
            missing=tuple(self._missing),
        )

    def _file(self, path: Path, what: str, read: Callable[[Path], T]) -> T | None:
        if not path.is_file():
            self._missing.append(f'no {what}: {path.name} is not there')
            return None
        try:
            return read(path)
        except (OrchestratorError, ScenarioError, OSError, TypeError, ValueError) as error:
            first = str(error).splitlines()[0]
            self._missing.append(f'no {what}: {_naming(path, first)}')
            return None

    def _check(
        self, plan: SurveyPlan | None, log: FlightLog | None, photographs: tuple[Photograph, ...]
    ) -> None:
        """List what a complete run would have."""
        self._file(self._run.mosaic, 'map', _require_raster)
        expected = plan.viewpoint_count if plan else 0
        if len(photographs) < expected:
            self._missing.append(
                f'{expected - len(photographs)} of {expected} photographs are not stored'
            )
        elif not photographs and plan is None:
            self._missing.append('no photographs')
        if log is not None and not log.readings:
            self._missing.append('no dose-rate readings in the recording')


def _plan(path: Path) -> SurveyPlan:
    return read_plan(path, needs_terrain=False)


def _json_object(path: Path) -> dict[str, object]:
    content = json.loads(path.read_text(encoding='utf-8'))
    if not isinstance(content, dict):
        raise TypeError(f'{path.name} is no JSON object')
    return content


def _require_raster(path: Path) -> None:
    """Raise ValueError unless `path` is a georeferenced image."""
    try:
        with rasterio.open(path) as raster:
            if raster.crs is None:
                raise ValueError(f'{path.name} has no georeference')
    except (RasterioError, OSError) as error:
        raise ValueError(f'{path.name} cannot be read as an image') from error


def _naming(path: Path, text: str) -> str:
    return text if path.name in text else f'{path.name}: {text}'
