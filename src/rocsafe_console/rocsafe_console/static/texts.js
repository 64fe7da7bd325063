// SPDX-License-Identifier: Apache-2.0
// Every text of the page, in one catalogue. A translation replaces the values of TEXTS, {name} is
// filled in, and writes beside each of REFUSALS, and of MISSION_TEXTS in mission_texts.js, what it is
// to be; '' leaves it as it is.
export const TEXTS = {
  skip: 'To the facts', view_live: 'Live', view_runs: 'Runs', view_draft: 'New mission',
  sound_on: 'Sound on', sound_off: 'Sound off', sound_waiting: 'No sound', places: 'Places', places_decimal: 'Deg', places_dms: 'DMS', places_mgrs: 'MGRS', theme: 'Theme', theme_dark: 'Night', theme_light: 'Day',
  map: 'Map', layers: 'Layers', no_mission: 'No mission is heard',
  live: 'live', not_live: 'not live', idle: 'no mission', stale: 'stale', place_old: 'its place is old', ago: '{age} ago', never: 'not heard yet',
  banner_lost: 'Not live: no word from the server for {age}. What you see is old.',
  banner_mission: 'No word from the mission for {age}. Grey is old.',
  banner_over: 'The mission has ended: {phase}. What you see is its last state.', over: 'ended', over_runs: 'Replay and evidence',
  banner_ended: 'The console has ended. Missions, reports and replays are shown again by: rocsafe console',
  fact_worst: 'Worst reading', fact_now: 'Newest', fact_sources: 'Sources', fact_zones: 'Zones', fact_wind: 'Wind',
  fact_coverage: 'Coverage', fact_time: 'Time left', fact_picture: 'Newest picture', fact_camera: 'Camera', video_vehicle: 'Camera of', video_none: 'no camera', video_scene: 'Scene (rocsafe scene show)', video_of: 'Camera of {vehicle}', video_waiting: 'no picture heard yet', video_live: 'taken {age} ago', video_old: 'old: taken {age} ago', fact_vehicles: 'Vehicles',
  fact_alarms: 'Alarms', fact_mosaic: 'Mosaic', fact_report: 'Incident report',
  report_later: 'at the end of the mission',
  no_reading: 'no reading yet', no_source: 'no source is supported by the readings', no_zone: 'no ground above a level', no_estimate: 'not estimated yet',
  no_wind: 'no wind measured', no_picture: 'no photograph yet', no_plan: 'no plan yet', no_alarm: 'no alarm', no_vehicle: 'no vehicle is heard',
  by_at: '{vehicle}, {detector}', trend_rising: 'rising', trend_falling: 'falling', trend_steady: 'steady',
  saturated: 'at least: the detector is saturated',
  source_line: '{strength} at 1 m, ±{size} m, with {probability}', source_name: 'Source {id}', gas_verdict: 'Gas: {text}', release_name: 'Release {id}', release_line: '{low} to {high} {unit} of {agent}, within {size} m',
  zone_line: '{level} within {radius} m', zone_upper: 'upper 95 %', gas_zone_line: '{level}: {radius} m from release',
  wind_line: 'from {from}° at {speed} m/s', wind_by: 'by {vehicle}', access_line: 'Approach from upwind: {side}.',
  coverage_line: '{stored} of {expected} photographs stored', coverage_visited: '{stored} of {expected} viewpoints visited', time_line: 'planned {planned}, at least {bound}',
  mosaic_line: '{count} photographs placed, {resolution} m a pixel', mosaic_draft: 'growing', mosaic_final: 'final',
  battery: 'battery', way_home: 'home in', battery_left: 'left for', dose: 'dose', link: 'link', led_by: 'led by {holder}', led_by_nobody: 'led by nobody',
  taken_by: 'taken by its {who}', visited: '{done} of {all}', select: 'Select {name}', fleet_stale: '{count} stale', fleet_turn: 'first to turn home: {vehicle}, in {value}', fleet_link: 'oldest link: {vehicle}, {value}', fleet_dose: 'most dose: {vehicle}, {value}', acknowledge: 'Seen', seen_by: 'seen by {who}',
  simulated: 'simulated', advice: 'advice: {advice}', unknown: '–',
  verb_hold: 'Hold', verb_resume: 'Resume', verb_return: 'Return', verb_land: 'Land', verb_take: 'Take over', verb_release: 'Give back', verb_go_to: 'Go here', verb_send: 'Drive', verb_replan: 'Plan anew',
  place_send: 'Plan a drive of {vehicle} here', place_dose: 'Dose budget, µSv', planning_drive: 'planning the drive …',
  drive_offer: '{vehicle} drives {time} (at least {bound}), {dose}, in 95 of 100 cases below {upper}', drive_left_out: 'not reached: {what}', drive_line: 'route: {time}, {dose}, 95 %: {upper} of {budget}',
  verb_mark: 'Mark', orders_for: 'For {what}', orders_for_live: 'Live mission, for {what}', orders_all: 'all {count} vehicles', orders_none: 'no vehicle',
  confirm: 'Confirm: {verb} {what}', confirm_touch: 'Keep pressed: {verb} {what}', cancel: 'Cancel', confirm_left: '{seconds} s',
  sending: 'sending …', sent: '{verb}: {done} of {all} done', sent_unknown: '{verb}: no answer from the server. The vehicles may have obeyed: look at them.', unlogged: 'The outcome is not in the evidence log: {why}', results: 'Results', close: 'Close',
  login_name: 'Name', login_password: 'Password', login_go: 'Log in', login_token: 'Open the address that the console printed: it has the token.',
  login_title: 'ROCSAFE console', who: '{user}, {role}', revoked: 'Your session has ended.',
  measure: 'Measure from here', measure_hint: 'Choose places on the map.', measure_leg: '{length} m, bearing {bearing}°', measure_all: '{length} m in all', measure_area: '{area} m² within',
  copy: 'Copy', mark_text: 'What is here?', mark_save: 'Mark as evidence', place_go_to: 'Send {vehicle} here', place_height: 'Height, m',
  runs_title: 'Runs', runs_none: 'no run in this folder', run_replay: 'Replay', run_report: 'Report', run_sealed: 'sealed', replay_stop: 'Back to live', replay_play: 'Play', replay_pause: 'Pause', replay_time: 'Time of the replay',
  layer_mosaic: 'Mosaic', layer_dose: 'Dose map', layer_cordons: 'Cordons', layer_plume: 'Gas', layer_zones: 'Threat zones', layer_routes: 'Planned routes', layer_drive: 'Drive, planned', layer_tracks: 'Flown tracks', layer_footprints: 'Footprints', layer_region: 'Region', layer_exclusions: 'Exclusions', layer_sources: 'Sources, 95 %', layer_homes: 'Homes', layer_marks: 'Marks', layer_contact: 'Contact: who hears whom', layer_grid: 'Grid', layer_base: 'Base map',
  legend: 'Dose rate, µSv/h', legend_gas: 'Gas, ppm', decisions: 'What was decided',
  help_title: 'Keys', help: 'h\tHold\nr\tResume\nb\tReturn\nl\tLand\np\tPlan anew\nEnter\tConfirm\nEsc\tCancel\na\tSeen\nt\tTheme\n1 2 3\tViews\nf\tShow all\ng\tGo to a place\nm\tMeasure on the map: distance, bearing, area\n?\tKeys\nmap\tarrows, + and -, Enter chooses its middle\nc\tclose the ring that is drawn, Backspace takes back its last corner',
  link_make: 'Address for QGIS', draft_title: 'New mission', draft_start: 'Begin with', draft_region: 'Draw the region', draft_exclusion: 'Draw an exclusion', draft_home: 'Set a home', draft_done: 'Close the ring', draft_undo: 'Undo', draft_import: 'Import a region (GeoJSON, KML, QGroundControl, CSV)',
  draft_save: 'Check', draft_plan: 'Plan', draft_preflight: 'Preflight', draft_approve: 'I approve this plan', draft_launch: 'Launch', draft_area: '{area} m², {count} corners', draft_running: '{step}: at work for {seconds} s, at most {most} s a step', draft_launching: 'launching: it is on the map in some seconds', draft_name: 'Name', draft_text: 'Scenario', draft_fault_line: 'line {line}',
  state_unknown: 'unknown', state_disarmed: 'disarmed', state_armed: 'armed', state_taking_off: 'taking off', state_flying: 'flying', state_holding: 'holding', state_returning: 'returning', state_landing: 'landing', state_landed: 'landed', state_lost: 'lost', state_crashed: 'crashed', state_waiting: 'waiting', state_driving: 'driving', state_parked: 'parked', state_standing: 'standing', state_arrived: 'arrived',
  compass: 'N NE E SE S SW W NW', north_letter: 'N', mission_clock: 'T+{time}', local_time: '{time} local', views: 'Views', facts: 'Facts', orders: 'Orders', north: 'North is up', zoom_in: 'Zoom in', zoom_out: 'Zoom out',
  map_keys: 'Map: arrows move it, plus and minus zoom, Enter chooses its middle', find: 'Go', find_label: 'Go to a place', find_hint: 'degrees, DMS, UTM or MGRS',
  people_title: 'People', people_none: 'Only you are logged in.', people_end: 'End', people_you: 'you', people_since: 'since {time}', log_out: 'Log out',
  draft_vehicles: 'Vehicles', draft_vehicle_add: 'Add a vehicle', draft_camera: 'Camera', draft_horizontal_fov_deg: 'Field of view, °', draft_image_width_px: 'Width, px', draft_image_height_px: 'Height, px',
  mission_log: 'What the mission prints', mission_end: 'End the mission', mission_end_sure: 'Press again: end the mission', mission_running: 'is running', mission_done: 'has ended well', mission_failed: 'has failed', mission_unknown: 'not launched by this console', mission_confirm: 'Launch again: real vehicles take off by plan {hash}',
  run_verify: 'Verify', run_seal: 'Seal', run_whole: 'every byte is as sealed in {seal}', run_signed: 'signed with {signer}', run_unsigned: 'not signed', run_changed: 'changed: {what}', run_working: 'reading all files …', run_new_seal: 'sealed: {seal}',
  gas_reading: '{value} {unit}', fact_gas: 'Worst gas reading', below_limit: 'below the limit of detection',
  phase_starting: 'starting', phase_planning: 'planning', phase_flying: 'flying', phase_collecting: 'collecting', phase_mapping: 'mapping', phase_reporting: 'reporting', phase_complete: 'complete', phase_failed: 'failed', phase_cancelled: 'cancelled', phase_driving: 'driving', phase_unknown: 'unknown',
  hears: 'hears {names}', hears_nobody: 'hears no other vehicle',
  hidden: 'This mission is open to named people only. Ask its commander to put you on its list.',
  commanded_by: 'commander: {name}', commanded_by_nobody: 'no commander', access: 'People', access_title: 'Who commands and sees {run}', access_commander: 'Commander of the mission', access_visibility: 'Who sees it', access_everybody: 'everybody who is logged in', access_named: 'its commander, the list, and commanders', access_members: 'List: who gives orders (names, with commas; empty: every operator)', access_save: 'Save', access_take: 'Take command', access_list: 'list: {names}', access_open: 'every operator', access_named_short: 'seen by named people only',
  job_resume: 'Resume', job_report: 'Report anew', job_replay: 'Localize and map again', job_whatif: 'What if', job_campaign: 'Fly the campaign', job_clear: 'Vehicle is clean', job_sure: 'Press again: {job}', job_end: 'End', job_running: '{job} {name}: at work', job_done: '{job} {name}: done', job_failed: '{job} {name}: failed', job_unknown: '{job} {name}: not begun here',
  campaigns: 'Campaigns', campaigns_none: 'no campaign beside the scenarios', campaign_page: 'Results', clear_title: 'Contaminated vehicles', clear_label: 'Name of a vehicle that was checked and is clean',
  replay_mark: 'Replay: not live', replay_events: 'Recorded until here', replay_none: 'nothing yet', event_photograph: '{vehicle}: photograph {shot} stored', event_state: '{vehicle}: {state}',
  outcome_done: 'done', outcome_refused: 'refused', outcome_silent: 'no answer', outcome_stale: 'state has changed', state_now: '(now: {state})',
  critical: 'critical', warning: 'warning', refused: 'Refused: {why}',
};

// What the server refuses and tells in alarms; test_texts.py compares it with the code.
export const REFUSALS = {
  "MGRS {0} {1}: both numbers must have as many digits": "",
  "MGRS {0}{1} {2}{3}: there is no such square": "",
  "a ring must have 3 to {0} corners": "",
  "alarm {0}: there is none": "",
  "campaign {0}: has no page yet": "",
  "cell_m = {0}: must be positive": "",
  "collection {0}: there is none": "",
  "command {0}: there is none": "",
  "confirm: must be hashes as the log of the mission tells them": "",
  "dose_budget_usv = {0}: must be above 0 and at most {1} uSv": "",
  "evidence log damaged: {0}": "",
  "files must be a mapping, lines a number": "",
  "height_m = {0}: must be within {1} and {2} m": "",
  "latitude {0}, longitude {1}: must be within -90 and 90, -180 and 180 degrees": "",
  "log in first": "",
  "marks: there are {0} already, which is the most": "",
  "members: must be a list of names": "",
  "members: {0}, must be {1} at most": "",
  "name {0}: must be up to 61 letters, digits, \"_\" and \"-\"": "",
  "no answer within {0} s": "",
  "no way was found within {0} s": "",
  "not as it was written": "",
  "not confirmed within {0} s: nothing was sent": "",
  "not ended": "",
  "not on disk within {0} s": "",
  "not planned anew: {0}": "",
  "nothing is launched: the evidence log: {0}": "",
  "nothing was sent: the evidence log cannot be written: {0}": "",
  "number = {0}, state = {1}: must be within 0 and {2}, and 0 and {3}": "",
  "order {0}: none is waiting for you to confirm it": "",
  "order {0}: there is another one of this id": "",
  "place {0}, {1}: must be on the earth": "",
  "place {0}: must be like {1}": "",
  "place {0}: write a point for decimals, and two numbers": "",
  "request_id must be 16 to 64 letters, digits and \"-\"": "",
  "run {0}: there is none": "",
  "session {0}: there is none": "",
  "target {0}, {1}: must be on the earth": "",
  "target: go_to and send need one of their own, nothing else has one": "",
  "target: must be a place to drive to": "",
  "target: {0} has none": "",
  "text has {0} letters: must have 1 to {1}": "",
  "the body did not come within {0} s": "",
  "the body is nested too deeply": "",
  "the body must be a JSON object": "",
  "the body must be application/json": "",
  "the command rocsafe is not on the PATH: source the workspace": "",
  "the mission cannot be reached": "",
  "the mission has failed: {0}": "",
  "the name of a log must be that of a file": "",
  "the name or the password is not right": "",
  "the password has {0} letters: must have {1} to {2}": "",
  "the request does not come from this page": "",
  "the role {0} may not {1}": "",
  "the token is not right: take the address that the console has printed": "",
  "there is no base map": "",
  "there is none yet": "",
  "this is no link": "",
  "this mission is commanded by {0}: take its command first": "",
  "this page belongs to one mission and hears no other: start rocsafe console": "",
  "this page is not served as {0}: name it by --name": "",
  "this photograph is not on this machine": "",
  "too many attempts": "",
  "too many attempts: wait {0} s": "",
  "too many pages look at cameras": "",
  "too many requests: wait {0} s": "",
  "user {0}: there is none": "",
  "vehicle {0}: there is none": "",
  "vehicle {0}: there is none that it could be like": "",
  "vehicles: must be one or more": "",
  "verb {0} is no order to a vehicle": "",
  "visibility = {0}: must be {1} or {2}": "",
  "you are not on the list of this mission": "",
  "zone {0}: must be 1 to 60": "",
  "{0} cells: must be full rows of {1}": "",
  "{0} does not drive": "",
  "{0} has changed since you looked: look again": "",
  "{0} has no file {1} to fetch": "",
  "{0} has not ended: it is sealed at its end": "",
  "{0} holds no signing key: make one by seal --make-key": "",
  "{0} is flying: end it first": "",
  "{0} is not on the list of those who command this mission": "",
  "{0} is not part of this mission": "",
  "{0} is not sealed": "",
  "{0} is signed with {1}: sign with this key, too": "",
  "{0} is taken by its {1}": "",
  "{0} of {1} is in no evidence log: {2}": "",
  "{0} {1} m are not in zone {2}, band {3}": "",
  "{0}: cannot be reached": "",
  "{0}: cannot be read: {1}": "",
  "{0}: cannot be shown: {1}": "",
  "{0}: has a signature and no public key": "",
  "{0}: has been changed": "",
  "{0}: has {1} lines, {2} were sealed": "",
  "{0}: is not signed with the key {1}": "",
  "{0}: is not the log that was sealed": "",
  "{0}: its format is {1}": "",
  "{0}: more than {1} vehicles": "",
  "{0}: must be a mapping": "",
  "{0}: must be for one vehicle: two would meet": "",
  "{0}: must be one of {1}": "",
  "{0}: not done within {1} s": "",
  "{0}: photograph {1} rejected: {2}": "",
  "{0}: the signature is not right": "",
  "{0}: there is none": "",
  "{0}: this console has no such mission running": "",
  "{0}: {1} does not lead it": "",
  "{0}: {1} reached {2}, {3}": "",
  "{0}; it turns back": "",
  "{0}′ {1}″: must be below 60": ""
};

export function t(key, values = {}) {
  const text = TEXTS[key];
  if (text === undefined) throw new Error(`no text: ${key}`);
  return text.replace(/\{(\w+)\}/g, (_, name) => String(values[name] ?? ''));
}

// Fills the elements that name their text.
export function fillTexts(within = document) {
  for (const element of within.querySelectorAll('[data-text]')) element.textContent = t(element.dataset.text);
  for (const element of within.querySelectorAll('[data-label]')) element.setAttribute('aria-label', t(element.dataset.label));
  for (const element of within.querySelectorAll('[data-hint]')) element.placeholder = t(element.dataset.hint);
}

// A text of the server, of a vehicle or of an estimate in the words of the catalogue; what it does not
// know stays as it is. What it says may end with another text.
const patternsOf = (texts) => Object.entries(texts).filter(([, own]) => own).map(([english, own]) => [new RegExp(`^${english.replace(/[.*+?^$()|[\]\\]/g, '\\$&').replace(/\{\d\}/g, '(.+?)')}$`, 's'), own, english.replace(/\{\d\}/g, '').length, english.startsWith('{')]);
let patterns = patternsOf(REFUSALS);
export function addTexts(texts) { patterns = [...patterns, ...patternsOf(texts)].sort((a, b) => b[2] - a[2]); }
addTexts({});
function whole(text, isOpen) {
  for (const [pattern, own, , begins] of patterns) {
    const found = begins === isOpen && pattern.exec(text);
    if (found) return own.replace(/\{(\d)\}/g, (_, number) => told(found[Number(number) + 1]));
  }
  return null;
}
// Sentences stand in a row, or behind the name of whom they are of.
const PARTS = [/^(.+?)(; )(.+)$/s, /^(.+?)(: )(.+)$/s, /^(.+?)(, )(.+)$/s, /^([\w-]+)( )(.+)$/s];
function parted(text) {
  const [, head, mark, rest] = PARTS.map((pattern) => pattern.exec(text)).find(Boolean) ?? [];
  if (!mark) return null;
  const both = mark === ' ' ? [head, whole(rest, false) ?? rest] : [told(head), told(rest)];
  return both[0] === head && both[1] === rest ? null : both.join(mark);
}
// First what begins with words of its own, then what begins with a value.
export function told(text) {
  if (!patterns.length || !text) return text;
  const [, before, core, after] = /^(\s*)(.*?)(\s*)$/s.exec(text);
  return before + (whole(core, false) ?? parted(core) ?? whole(core, true) ?? core) + after;
}
