# SPDX-License-Identifier: Apache-2.0
"""Background reads of a vehicle: message rates, settings, fence, mission.

Reading changes nothing of what a vehicle does: message rates that are missing are asked for,
settings are read on the ground, fence and rally points always, the mission in the air.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Any

from rocsafe_mavlink.autopilots.autopilot import Autopilot
from rocsafe_mavlink.autopilots.parameters import PARAMETER, ParameterReader
from rocsafe_mavlink.knowledge.telemetry import Contact, VehicleTelemetry
from rocsafe_mavlink.plan.fence import fence_of, rally_of
from rocsafe_mavlink.plan.flight_limits import VehicleSettings
from rocsafe_mavlink.protocols.command_call import set_interval
from rocsafe_mavlink.protocols.mission_download import Download, DownloadStage
from rocsafe_mavlink.protocols.mission_results import MissionType
from rocsafe_mavlink.protocols.onboard_mission import OnboardMission
from rocsafe_mavlink.protocols.stream_rates import StreamRates
from rocsafe_mavlink.wire.dialect import Message

Target = tuple[int, int]
# Another station may change mission, fence and rally points at any time: they are read again so
# often, in the air too.
READ_AGAIN_S = 30.0
# A PX4 that waits for an upload of a bridge that is gone asks for its items four times a second. A
# reading begun meanwhile would leave it refusing every upload, so it is listened to first.
QUIET_S = 2.0


@dataclass(slots=True)
class Readout:
    """Reads settings, fence and mission of one vehicle, and owns what is known of them.

    Attributes
    ----------
    target
        (system, component) of the vehicle.
    rates
        Watches the rates of its messages.
    settings
        Its parameters, fence and rally points, as far as they are read.
    mission
        State of the mission on the vehicle.
    """

    target: Target
    rates: StreamRates
    settings: VehicleSettings = field(default_factory=VehicleSettings)
    mission: OnboardMission = field(default_factory=OnboardMission)
    _download: Download | None = None
    _was_lost: bool = False
    _mission_read_s: float = -math.inf
    _fence_read_s: float = -math.inf
    _rally_read_s: float = -math.inf
    _quiet_until_s: float = -math.inf

    def on_message(self, message: Message, now_s: float) -> list[Message]:
        """Take a message of the vehicle; return what to send."""
        if self.settings.parameters is not None and message.name == PARAMETER:
            self._note(parameters=self.settings.parameters.on_message(message))
        if self._download is None:
            return []
        self._download, sent = self._download.on_message(message, now_s)
        self._keep_if_read(now_s)
        return sent

    def on_tick(
        self,
        vehicle: VehicleTelemetry,
        kind: Autopilot | None,
        now_s: float,
        *,
        is_commanded: bool,
    ) -> list[Message]:
        """Let time pass; return what to send.

        `kind` is None where no autopilot is known. Nothing is begun to be read while the vehicle
        `is_commanded`.
        """
        contact = vehicle.contact(now_s)
        if contact is Contact.LOST:
            self._was_lost = True
        if contact is not Contact.FRESH:
            self.wait(now_s)
            return []
        if self._was_lost:
            # Another station may have changed what lies on it.
            self._was_lost, self.mission = False, self.mission.forgotten()
            self.forget_fence()
        read = self._read(vehicle, kind, now_s, is_commanded=is_commanded)
        return self._missing_rates(kind, now_s) + read

    def forget(self) -> None:
        """Forget all that a vehicle that was started again may have changed."""
        self.forget_mission()
        self._note(parameters=None)
        self.forget_fence()
        self._forget_rally()

    def wait(self, now_s: float) -> None:
        """Begin no reading for a while, see `QUIET_S`."""
        self._quiet_until_s = now_s + QUIET_S

    def overwritten(self, kind: MissionType) -> None:
        """Note that we are about to overwrite a list on the vehicle.

        A reading under way is thrown away: the first part of what it gives may be the old list.
        """
        self._download = None
        if kind is MissionType.MISSION:
            self.mission = self.mission.upload_begun()
        elif kind is MissionType.FENCE:
            self.forget_fence()
        else:
            self._forget_rally()

    def forget_mission(self) -> None:
        """Forget the mission, which may be another by now; a reading under way is thrown away."""
        self.mission = self.mission.forgotten()
        self._download = None

    def forget_fence(self) -> None:
        """Forget the fence, which may be another by now, and what was read of it so far."""
        self._note(fence=None, fence_error='')
        self._fence_read_s = -math.inf
        if self._download is not None and self._download.mission_type == MissionType.FENCE:
            self._download = None

    def _forget_rally(self) -> None:
        self._note(rally=None, rally_error='')
        self._rally_read_s = -math.inf

    def _missing_rates(self, kind: Autopilot | None, now_s: float) -> list[Message]:
        due = self.rates.due(now_s, frozenset() if kind is None else kind.unsent)
        return [] if due is None else [set_interval(self.target, *due)]

    def _read(
        self,
        vehicle: VehicleTelemetry,
        kind: Autopilot | None,
        now_s: float,
        *,
        is_commanded: bool,
    ) -> list[Message]:
        """Read one thing after the other: mission in the air, fence, settings, rally points."""
        if self._download is not None:
            self._download, sent = self._download.on_tick(now_s)
            self._keep_if_read(now_s)
            return sent
        if not vehicle.is_armed:
            self.mission = self.mission.unread()
        if is_commanded or now_s < self._quiet_until_s:
            return []
        if vehicle.is_armed and now_s - self._mission_read_s > self._mission_lasts_s:
            return self._begin(MissionType.MISSION, now_s)
        if now_s - self._fence_read_s > READ_AGAIN_S:
            return self._begin(MissionType.FENCE, now_s)
        asked = self._read_parameters(kind, now_s)
        parameters = self.settings.parameters
        is_next = now_s - self._rally_read_s > READ_AGAIN_S
        if is_next and parameters is not None and parameters.is_over:
            return self._begin(MissionType.RALLY, now_s)
        return asked

    @property
    def _mission_lasts_s(self) -> float:
        """For how long the mission that was read counts: one item a second is no load."""
        items = self.mission.items
        return -math.inf if items is None else max(READ_AGAIN_S, float(len(items)))

    def _begin(self, kind: MissionType, now_s: float) -> list[Message]:
        download = Download(target=self.target, mission_type=kind)
        self._download, sent = download.begin(now_s)
        return sent

    def _keep_if_read(self, now_s: float) -> None:
        """Note what was read, and when: a reading that was thrown away is begun again at once."""
        done = self._download
        if done is None or done.stage not in (DownloadStage.DONE, DownloadStage.FAILED):
            return
        self._download = None
        if done.mission_type == MissionType.MISSION:
            self._mission_read_s = now_s
            if done.stage is DownloadStage.DONE:
                self.mission = self.mission.read(done.items)
        elif done.mission_type == MissionType.RALLY:
            self._rally_read_s = now_s
            is_read = done.stage is DownloadStage.DONE
            self._note(rally=rally_of(done.items) if is_read else None, rally_error=done.error)
        else:
            self._fence_read_s = now_s
            self._keep_fence(done)

    def _keep_fence(self, done: Download) -> None:
        fence, error = None, done.error
        if done.stage is DownloadStage.DONE:
            try:
                fence = fence_of(done.items)
            except ValueError as fault:
                error = str(fault)
        self._note(fence=fence, fence_error=error)

    def _read_parameters(self, kind: Autopilot | None, now_s: float) -> list[Message]:
        if kind is None:
            return []
        known = self.settings.parameters
        if known is None or known.kind != kind.name:
            known = ParameterReader(kind=kind.name, target=self.target, found={})
        parameters, sent = known.on_tick(now_s)
        if parameters is not self.settings.parameters:
            self._note(parameters=parameters)
        return sent

    def _note(self, **changes: Any) -> None:
        self.settings = replace(self.settings, **changes)
