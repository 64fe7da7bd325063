# SPDX-License-Identifier: Apache-2.0
"""What happens at random during a run of `test_state_machines`: each is called with the run."""

from test.mavlink.hostile_vehicle import HOME_E7, OTHER, PILOT
from test.mavlink.test_advice import adsb

from rocsafe_mavlink.wire.authority import COMMANDS


def _pilot(run):
    mode = run.rng.choice(run.vehicle.modes['pilot'])
    if run.vehicle.is_armed:
        run.vehicle.take(PILOT, mode, run.now_s)


def _pilot_presses_return(run):
    if run.vehicle.is_armed:
        run.vehicle.take(PILOT, run.vehicle.modes[run.rng.choice(('return', 'land'))], run.now_s)


def _other_station(run):
    if run.vehicle.is_armed:
        mode = run.vehicle.modes[run.rng.choice(('mission', 'guided', 'hold'))]
        run.vehicle.take(OTHER, mode, run.now_s)


def _failsafe(run):
    if run.vehicle.is_armed:
        run.vehicle.fail(run.now_s)


def _reboot(run):
    run.vehicle.reboot(run.now_s)


def _overwrite(run):
    run.vehicle.overwrite(run.now_s)


def _swap_before_resume(run):
    """It holds by order, another station writes another mission, and the operator resumes."""
    run.order(lambda: run.drone.commands.hold(run.now_s))
    run.vehicle.overwrite(run.now_s)
    run.resume_s = run.now_s + run.rng.choice((1.0, 3.0, 8.0))


def _bridge_restarts(run):
    """It is killed and started again; the vehicle tells nothing twice."""
    run.restart()


def _current_moves(run):
    """Another station lets it go on with another item of its mission."""
    run.vehicle.current = run.rng.randrange(max(1, len(run.vehicle.stored[0])))


def _rally_moves(run):
    """Another station writes a rally point, anywhere."""
    place = (HOME_E7[0] + run.rng.choice((0, 20_000)), HOME_E7[1])
    run.vehicle.stored[2] = [(3, 5100, 0.0, 0.0, 0.0, 0.0, *place, 30.0)]


def _pilot_flies_a_round(run):
    """On the ground he starts the motors; two seconds later it has landed again."""
    vehicle = run.vehicle
    if not vehicle.is_armed:
        vehicle.is_armed = vehicle.is_flying = True
        vehicle.take(PILOT, run.rng.choice(vehicle.modes['pilot']), run.now_s)
        run.lands_s = run.now_s + 2.5


def _wind_blows(run):
    """For half a minute."""
    run.wind_until_s = run.now_s + 30.0


def _motors_stop(run):
    run.vehicle._land(run.now_s)


def _pilot_arms(run):
    run.vehicle.is_armed = True
    run.vehicle.take(PILOT, run.rng.choice(run.vehicle.modes['pilot']), run.now_s)


def _cut(run):
    """Nothing is heard for a while, and often nothing arrives either."""
    run.cut_until_s = run.now_s + run.rng.choice((1.0, 4.0, 15.0))
    run.down.is_cut, run.up.is_cut = True, run.rng.random() < 0.5


def _home_moves(run):
    run.vehicle.home = (HOME_E7[0] + 9000, HOME_E7[1])


def _home_rises(run):
    run.vehicle.home_mm = run.rng.choice((480_000, 488_000, 530_000))


def _odd_heartbeat(run):
    run.vehicle.beat_oddly()


def _odd_clock(run):
    run.vehicle.boot_s += run.rng.choice((-500.0, -3.0, 1.0, 3.0))


def _clock_wraps(run):
    """Its clock of 32 bits begins anew 20 s later, after 50 days."""
    run.vehicle.boot_s = run.now_s + 20.0 - 2**32 / 1000.0


def _fails_in_upload(run):
    run.vehicle.fails_in_upload = True


def _component_beats(run):
    run.vehicle.beat_beside()


def _old_count(run):
    """The link repeats what was said of another mission long ago."""
    vehicle = run.vehicle
    vehicle.say('MISSION_CURRENT', **run.rng.choice(vehicle.told_missions))


def _estimate_jumps(run):
    """The estimator's origin is set anew, or it loses its place for a while."""
    run.vehicle.shift_e7 = run.rng.choice((0, 3000, 60_000))
    run.vehicle.is_lost_until_s = run.now_s + run.rng.choice((0.0, 5.0, 20.0))


def _obeys_another(run):
    """Its station is set to another, which may switch it."""
    run.vehicle.obeys_another = not run.vehicle.obeys_another
    run.vehicle.settings['SYSID_MYGCS'] = 254.0 if run.vehicle.obeys_another else 255.0
    if run.rng.random() < 0.5:
        _other_station(run)


def _passing_mode(run):
    """The pilot takes it, and another station gives it back before it says so."""
    _pilot(run)
    _other_station(run)


def _stuck(run):
    run.vehicle.is_stuck = not run.vehicle.is_stuck


def _noise(run):
    vehicle, rng = run.vehicle, run.rng
    kind = rng.randrange(3)
    rng.choice(
        (
            lambda: vehicle.say('COMMAND_ACK', command=rng.choice(list(COMMANDS)), result=0),
            lambda: vehicle.say('MISSION_ACK', type=rng.randrange(20), mission_type=kind),
            lambda: vehicle.say('MISSION_REQUEST_INT', seq=rng.randrange(9), mission_type=kind),
            lambda: vehicle.say('MISSION_COUNT', count=rng.randrange(70000), mission_type=kind),
            lambda: vehicle.say('MISSION_ITEM_REACHED', seq=rng.randrange(70)),
            lambda: vehicle.say(
                'MISSION_CURRENT', seq=rng.randrange(70), mission_state=9, total=rng.randrange(9)
            ),
            lambda: vehicle.say('FENCE_STATUS', breach_status=0),
            lambda: vehicle.say('WIND', speed=30.0 * rng.random()),
            lambda: vehicle.say('ADSB_VEHICLE', **adsb(0.0, 900.0 * rng.random()).fields),
            lambda: vehicle.say('EXTENDED_SYS_STATE', landed_state=rng.randrange(9)),
        )
    )()


MISFORTUNES = (
    *(_pilot, _pilot, _pilot, _pilot_presses_return, _pilot_arms, _passing_mode, _other_station),
    *(_failsafe, _failsafe, _failsafe, _failsafe, _failsafe, _fails_in_upload, _motors_stop),
    *(_overwrite, _overwrite, _swap_before_resume, _swap_before_resume, _old_count, _reboot),
    *(_cut, _cut, _stuck, _noise, _noise, _noise, _odd_heartbeat, _odd_heartbeat),
    *(_component_beats, _component_beats, _odd_clock, _clock_wraps, _obeys_another),
    *(_home_moves, _home_rises, _estimate_jumps, _bridge_restarts, _bridge_restarts),
    *(
        _rally_moves,
        _current_moves,
        _current_moves,
        _pilot_flies_a_round,
        _pilot_flies_a_round,
        _wind_blows,
    ),
)


def _is_nowhere(run):
    """It tells latitude and longitude 0, as before its first fix."""
    run.vehicle.nowhere_until_s = run.now_s + run.rng.choice((2.0, 15.0))


def _stream_stops(run):
    """One message does not come any more for a while, as after a change of rates."""
    names = ('MISSION_CURRENT', 'HOME_POSITION', 'GLOBAL_POSITION_INT', 'EXTENDED_SYS_STATE')
    run.vehicle.mute = run.rng.choice((*names, 'SYS_STATUS', 'COMMAND_ACK', 'STATUSTEXT'))
    run.vehicle.mute_until_s = run.now_s + run.rng.choice((5.0, 30.0))


def _landed_state_flaps(run):
    """As of a vehicle in gusts near the ground."""
    run.vehicle.flaps_until_s = run.now_s + 15.0


def _current_is_off(run):
    """It counts its items by one more or less than it was sent them."""
    run.vehicle.current_off = run.rng.choice((-1, 0, 1))


def _answers_another(run):
    """What it says is for another station, which has ordered and asked the same."""
    vehicle, rng = run.vehicle, run.rng
    other = {'target_system': 254, 'target_component': 190}
    number, result = rng.choice(list(COMMANDS)), rng.choice((0, 1, 2, 4, 5))
    vehicle.say('COMMAND_ACK', command=number, result=result, **other)
    for kind in range(3):
        vehicle.say('MISSION_ACK', type=rng.choice((0, 1, 5, 15)), mission_type=kind, **other)
        vehicle.say('MISSION_REQUEST_INT', seq=rng.randrange(9), mission_type=kind, **other)
        vehicle.say('MISSION_COUNT', count=rng.randrange(9), mission_type=kind, **other)


def _answers_late(run):
    """The link repeats what it answered some seconds ago, as it was."""
    number = run.rng.choice((176, 192, 193, 224, 300, 400))
    run.vehicle.say('COMMAND_ACK', command=number, result=run.rng.choice((0, 1, 4, 5)))


def _bridge_stands_still(run):
    """Stopped, swapped out, or on a machine that slept."""
    run.still_until_s = run.now_s + run.rng.choice((4.0, 12.0, 60.0))


STRANGE = (
    *MISFORTUNES,
    *(_is_nowhere, _is_nowhere, _stream_stops, _stream_stops, _stream_stops),
    *(_landed_state_flaps, _landed_state_flaps, _current_is_off, _current_is_off),
    *(_answers_another, _answers_another, _answers_another, _answers_late, _answers_late),
    *(_bridge_stands_still, _bridge_stands_still, _bridge_stands_still),
)
