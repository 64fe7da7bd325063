# SPDX-License-Identifier: Apache-2.0
"""A fake ArduPilot Rover: says and refuses what Rover 4.7 did in its own simulator.

It drives as a point at constant speed. It tells no landed state, takes no pause within a mission,
stays armed at the end of one, and comes back on its own tracks by SMART_RTL. A battery that is low
and a crash do not change its status, and no text names a failsafe.
"""

from test.fakes.fake_autopilot import ACCEPTED, DENIED, FAILED, STEP_S, FakeCopter

MANUAL, HOLD, AUTO, RTL, SMART_RTL, GUIDED = 0, 4, 10, 11, 12, 15
# FS_ACTION and BATT_FS_LOW_ACT.
ACTIONS = {2.0: HOLD, 3.0: SMART_RTL, 4.0: SMART_RTL}
MODES = {MANUAL, HOLD, AUTO, RTL, SMART_RTL, GUIDED}


class FakeRover(FakeCopter):
    """One rover on a link."""

    def _start(self):
        super()._start()
        self._stood_s = 0.0
        self._tracks = []
        self._armed_at = {}

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.parameters |= {'FS_ACTION': 2.0, 'MIS_DONE_BEHAVE': 0.0, 'SRTL_POINTS': 300.0}

    def lose_battery(self):
        """Low voltage for longer than its timer."""
        self._text(4, 'Battery 1 is low 10.60V used 274 mAh')
        self.mode = ACTIONS.get(self.parameters['BATT_FS_LOW_ACT'], self.mode)

    def crash(self):
        """It does not move although it should."""
        self._text(0, 'Crash: Going to HOLD')
        self.mode = HOLD

    def be_switched_off(self):
        """Its pilot stops the motors."""
        self.is_armed = False
        # Within its mission it keeps the item.
        self.current = self.current if self.mode == AUTO else 0

    def be_switched(self, mode):
        """Its pilot, or another station, switches its mode."""
        self.mode = mode

    def _fail_safe(self):
        silent_s = 0.0 if self._gcs_s is None else self._station_s - self._gcs_s
        is_silent = silent_s > self.parameters['FS_GCS_TIMEOUT']
        # Not while it stands by order.
        is_on = self.parameters['FS_GCS_ENABLE'] == 1.0 and self.mode != HOLD
        if is_on and is_silent and self.is_armed and self.status != 5:
            # As the real one, which names the one that it looked at last.
            self._text(4, 'Radio Failsafe')
            self.status, self.mode = 5, ACTIONS[self.parameters['FS_ACTION']]

    def _on_mode(self, message):
        mode = int(self._parameter(message, 2))
        if mode not in MODES:
            return FAILED
        if mode == AUTO and len(self.missions.stored[0]) < 2:
            self._text(5, "No Mission. Can't set AUTO.")
            return FAILED
        if mode == AUTO and self.is_armed:
            is_complete = self.mission_state == 5 or self.current < 1
            self.current = 1 if is_complete else self.current
            self.mission_state = 3
        self.mode = mode
        return ACCEPTED

    def _on_arm(self, message):
        if self._parameter(message, 1) == 1.0:
            self.is_armed = True
            # Its home is where it is armed, at height 0, as of the real one in its simulator.
            here = self._global_position_int()
            place = {'latitude': here['lat'], 'longitude': here['lon']}
            self._armed_at = {**place, 'altitude': 0}
        else:
            self.be_switched_off()
        return ACCEPTED

    def _on_current(self, message):
        self.mission_state = 2 if self.mission_state == 5 else self.mission_state
        return super()._on_current(message)

    def _on_start(self, message):
        # It takes neither a first nor a last item.
        if any(self._parameter(message, number) for number in (1, 2)):
            return DENIED
        self.mode = AUTO
        return ACCEPTED

    def _on_pause(self, message):
        del message
        return FAILED

    def _fly(self):
        self.velocity = (0.0, 0.0, 0.0)
        self.missions.is_flying = self.is_armed
        if not self.is_armed:
            return
        if self.mode == AUTO and self.mission_state == 3:
            self._tracks.append(self.place)
            self._drive_item()
        elif self.mode in (RTL, SMART_RTL) and self._tracks:
            self._approach(self._tracks.pop())

    def _drive_item(self):
        items = self.missions.stored[0]
        if self.current >= len(items):
            self.mission_state = 5
            self._text(5, 'Mission Complete')
            return
        item = items[self.current]
        if item.command != 16:
            self._do(item)
            self.current += 1
        elif self._approach(self._local(item.x_e7, item.y_e7)):
            self._stood_s += STEP_S
            if self._stood_s >= item.parameters[0]:
                self._stood_s = 0.0
                self._reached()

    def _speak(self):
        if self.status != 5 or not self.is_armed:
            self.status = 4 if self.is_armed else 3
        self._due('HEARTBEAT', 1.0, self._heartbeat)
        for name, period_s in self._rates.items():
            self._due(name, period_s, getattr(self, f'_{name.lower()}'))

    def _heartbeat(self):
        return {**super()._heartbeat(), 'type': 10}

    def _home_position(self):
        said = super()._home_position()
        return said and {**said, **self._armed_at}

    def _extended_sys_state(self):
        return {'landed_state': 0}
