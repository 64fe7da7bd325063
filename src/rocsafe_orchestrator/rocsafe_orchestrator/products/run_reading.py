# SPDX-License-Identifier: Apache-2.0
"""Reader of a run directory, complete or not."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import rasterio
from rasterio.errors import RasterioError

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.products.flight_log import read_flight_log
from rocsafe_orchestrator.products.photographs import read_photographs
from rocsafe_orchestrator.products.run_record import FlightLog, Photograph, RunRecord
from rocsafe_orchestrator.products.viewpoint_balance import viewpoint_balance
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
        further = self._further(log)
        photographs = read_photographs(self._run.images)
        plans = (plan, *further) if plan else further
        if scenario is not None and not scenario.has_cameras:
            self._missing.append('no photographs and no map: no vehicle has a camera')
        else:
            self._check_pictures(plans, photographs)
        if log is not None and not log.readings:
            self._missing.append('no dose-rate readings in the recording')
        return RunRecord(
            path=self._run.path,
            info=info,
            scenario=scenario,
            plan=plan,
            log=log,
            photographs=photographs,
            missing=tuple(self._missing),
            further=further,
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

    def _further(self, log: FlightLog | None) -> tuple[SurveyPlan, ...]:
        """Return the plans after the first, in the order in which they were flown."""
        found = (
            self._file(path, f'further plan {path.parent.name}', _plan)
            for path in self._run.further_plans
        )
        begun: dict[str, int] = {}
        for sample in sorted(
            (sample for samples in log.samples.values() for sample in samples) if log else (),
            key=lambda sample: sample.time_ns,
        ):
            begun.setdefault(sample.plan_id, sample.time_ns)
        return tuple(
            sorted(filter(None, found), key=lambda plan: begun.get(plan.plan_id, math.inf))
        )

    def _check_pictures(
        self, plans: tuple[SurveyPlan, ...], photographs: tuple[Photograph, ...]
    ) -> None:
        """List the photographs and the map that a complete run would have."""
        self._file(self._run.mosaic, 'map', _require_raster)
        balance = viewpoint_balance(plans, photographs)
        if balance.missing:
            self._missing.append(
                f'{balance.missing} of {balance.planned} viewpoints have no photograph'
            )
        elif not photographs and not plans:
            self._missing.append('no photographs')


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
