# SPDX-License-Identifier: Apache-2.0
"""The products of a run: recording, table of readings, summary and report."""

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.storage.durable import replace_whole
from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.parameters.air_parameters import ESTIMATOR
from rocsafe_orchestrator.parameters.terrain_parameters import ground_options
from rocsafe_orchestrator.process_table.scene_export import export_scenes
from rocsafe_orchestrator.products.agent_advice import advise
from rocsafe_orchestrator.products.flight_log import READING, read_flight_log
from rocsafe_orchestrator.products.readings_table import write_readings
from rocsafe_orchestrator.products.release_estimates import estimate_releases
from rocsafe_orchestrator.products.run_reading import read_run
from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_orchestrator.products.source_estimates import SourceEstimates, estimate_sources
from rocsafe_orchestrator.products.summary import RunSummary, summarise
from rocsafe_orchestrator.provenance import write_json
from rocsafe_orchestrator.recording.finalising import finalise, merge
from rocsafe_orchestrator.recording.segments import MISSION_FILE, segments
from rocsafe_orchestrator.report.page import report_page
from rocsafe_orchestrator.run_directory import RunDirectory


@dataclass(frozen=True, slots=True, kw_only=True)
class EarlyEstimates:
    """Sources that were estimated before all of a run was recorded, and their readings' table."""

    table: bytes
    estimates: SourceEstimates


def estimate_early(run: RunDirectory) -> EarlyEstimates | None:
    """Estimate sources from what is recorded so far; None: there is nothing to say."""
    path = run.spool / MISSION_FILE
    try:
        merge(segments(run.path), path, kinds=(READING,))
        record = dataclasses.replace(read_run(run.path), log=read_flight_log(path))
    finally:
        path.unlink(missing_ok=True)
    record = _without_idle_detectors(record)
    _write_readings(record, run)
    estimates = _with_estimates(record, run, None).estimates
    if estimates is None:
        return None
    return EarlyEstimates(table=run.readings.read_bytes(), estimates=estimates)


def write_products(run_directory: Path, early: EarlyEstimates | None = None) -> RunSummary:
    """Write or renew all products of the run in `run_directory`, and return its figures.

    Works on an interrupted run: summary and report list what is missing. May be repeated.

    Parameters
    ----------
    early
        Sources that are not estimated again if no other reading has come since.

    Raises
    ------
    ValueError
        If there is no such directory.
    OSError
        If a product cannot be written.
    """
    run = RunDirectory(run_directory.resolve())
    if not run.path.is_dir():
        raise ValueError(f'{run_directory} is no run directory')
    finalise(run.path, [run.scenario, run.run_info, run.plan])
    record = read_run(run.path)
    _write_readings(record, run)
    record = _with_estimates(_without_idle_detectors(record), run, early)
    record = _with_gas(record, run)
    summary = summarise(record)
    write_json(run.summary, summary.to_plain())
    page = report_page(record, summary, mission_frame(record))
    replace_whole(run.report, page.encode())
    return summary


def _write_readings(record: RunRecord, run: RunDirectory) -> None:
    readings = record.log.readings if record.log else ()
    write_readings(run.readings, readings, mission_frame(record))


def _without_idle_detectors(record: RunRecord) -> RunRecord:
    """Return `record` without the readings of simulated detectors that have nothing to read."""
    if record.log is None or record.scenario is None or record.scenario.has_radiation:
        return record
    return dataclasses.replace(record, log=dataclasses.replace(record.log, readings=()))


def _with_estimates(
    record: RunRecord, run: RunDirectory, early: EarlyEstimates | None
) -> RunRecord:
    """Return `record` with the sources that its readings support."""
    if record.log is None or not record.log.readings or record.scenario is None:
        return record
    if early is not None and early.table == run.readings.read_bytes():
        return dataclasses.replace(record, estimates=early.estimates)
    try:
        # Runs of earlier versions have no such files.
        export_scenes(record.scenario, run)
        ground = ground_options(record.scenario, run)
        options = (*ground, *record.scenario.radiation.localize_options)
        estimates = estimate_sources(run.readings, options)
    except OrchestratorError as error:
        line = f'no estimate of sources: {error}'
        return dataclasses.replace(record, missing=(*record.missing, line))
    return dataclasses.replace(record, estimates=estimates)


def _with_gas(record: RunRecord, run: RunDirectory) -> RunRecord:
    """Return `record` with the releases and the agent that its readings of gas support."""
    if record.scenario is None or not record.scenario.air.reads:
        return record
    parameters, missing = run.parameters_of(ESTIMATOR), record.missing
    found: dict[str, Any] = {}
    for name, what, find in (
        ('releases', 'no estimate of releases', estimate_releases),
        ('advice', 'no agent named', advise),
    ):
        if find is advise and not record.scenario.air.gas_sensors:
            continue
        try:
            found[name] = find(parameters, run.path)
        except OrchestratorError as error:
            missing = (*missing, f'{what}: {error}')
    return dataclasses.replace(record, missing=missing, **found)


def mission_frame(record: RunRecord) -> LocalFrame | None:
    """Return the local frame of the run: the scenario's, else about the plan's region."""
    if record.scenario is not None:
        return LocalFrame(record.scenario.origin_position())
    return None
