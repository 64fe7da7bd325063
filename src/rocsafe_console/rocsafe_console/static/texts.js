// SPDX-License-Identifier: Apache-2.0
// Every text of the page, in one catalogue. A translation replaces the values; {name} is filled in.
export const TEXTS = {
  skip: 'To the facts', view_live: 'Live', view_runs: 'Runs', view_draft: 'New mission',
  sound_on: 'Sound on', sound_off: 'Sound off', sound_waiting: 'No sound', places: 'Places', places_decimal: 'Deg', places_dms: 'DMS', places_mgrs: 'MGRS', theme: 'Theme', theme_dark: 'Night', theme_light: 'Day',
  map: 'Map', layers: 'Layers', no_mission: 'No mission is heard',
  live: 'live', not_live: 'not live', stale: 'stale', place_old: 'its place is old', ago: '{age} ago', never: 'not heard yet',
  banner_lost: 'Not live: no word from the server for {age}. What you see is old.',
  banner_mission: 'No word from the mission for {age}. Grey is old.',
  fact_worst: 'Worst reading', fact_now: 'Newest reading', fact_sources: 'Sources', fact_zones: 'Zones', fact_wind: 'Wind',
  fact_coverage: 'Coverage', fact_time: 'Time left', fact_picture: 'Newest picture', fact_camera: 'Camera', video_vehicle: 'Camera of', video_none: 'no camera', video_scene: 'Scene (rocsafe scene show)', video_of: 'Camera of {vehicle}', video_waiting: 'no picture heard yet', video_live: 'taken {age} ago', video_old: 'old: taken {age} ago', fact_vehicles: 'Vehicles',
  fact_alarms: 'Alarms', fact_mosaic: 'Mosaic', fact_report: 'Incident report',
  no_reading: 'no reading yet', no_source: 'no source is supported by the readings', no_zone: 'no ground above a level',
  no_wind: 'no wind measured', no_picture: 'no photograph yet', no_plan: 'no plan yet', no_alarm: 'no alarm', no_vehicle: 'no vehicle is heard',
  by_at: '{vehicle}, {detector}', trend_rising: 'rising', trend_falling: 'falling', trend_steady: 'steady',
  saturated: 'at least: the detector is saturated',
  source_line: '{strength} at 1 m, ±{size} m, with {probability}', source_name: 'Source {id}', gas_verdict: 'Gas: {text}', release_name: 'Release {id}', release_line: '{low} to {high} g/s of {agent}, within {size} m',
  zone_line: '{level} within {radius} m', zone_upper: 'upper 95 %', gas_zone_line: '{level} up to {radius} m from the release',
  wind_line: 'from {from}° at {speed} m/s', wind_by: 'measured by {vehicle}',
  coverage_line: '{stored} of {expected} photographs stored', time_line: 'planned {planned}, at least {bound}',
  mosaic_line: '{count} photographs placed, {resolution} m a pixel', mosaic_draft: 'growing', mosaic_final: 'final',
  battery: 'battery', way_home: 'home in', battery_left: 'left for', dose: 'dose', link: 'link', led_by: 'led by {holder}', led_by_nobody: 'led by nobody',
  taken_by: 'taken by its {who}', visited: '{done} of {all}', select: 'Select {name}', acknowledge: 'Seen', seen_by: 'seen by {who}',
  simulated: 'simulated', advice: 'advice: {advice}', unknown: '–',
  verb_hold: 'Hold', verb_resume: 'Resume', verb_return: 'Return', verb_land: 'Land', verb_take: 'Take over', verb_release: 'Give back', verb_go_to: 'Go here', verb_send: 'Drive', verb_replan: 'Plan anew',
  place_send: 'Plan a drive of {vehicle} here', place_dose: 'Dose budget, µSv', planning_drive: 'planning the drive …',
  drive_offer: '{vehicle} drives {time} (at least {bound}), {dose}, in 95 of 100 cases below {upper}', drive_left_out: 'not reached: {what}', drive_line: 'route: {time}, {dose}, 95 %: {upper} of {budget}',
  verb_mark: 'Mark', orders_for: 'For {what}', orders_for_live: 'Live mission, for {what}', orders_all: 'all {count} vehicles', orders_none: 'no vehicle',
  confirm: 'Confirm: {verb} {what}', confirm_touch: 'Keep pressed: {verb} {what}', cancel: 'Cancel', confirm_left: '{seconds} s',
  sending: 'sending …', sent: '{verb}: {done} of {all} done', sent_unknown: '{verb}: no answer from the server. The vehicles may have obeyed: look at them.', unlogged: 'The outcome is not in the evidence log: {why}', results: 'Results', close: 'Close',
  login_name: 'Name', login_password: 'Password', login_go: 'Log in', login_token: 'Open the address that the console printed: it has the token.',
  login_title: 'ROCSAFE console', who: '{user}, {role}', revoked: 'Your session has ended.',
  copy: 'Copy', mark_text: 'What is here?', mark_save: 'Mark as evidence', place_go_to: 'Send {vehicle} here', place_height: 'Height, m',
  runs_title: 'Runs', runs_none: 'no run in this folder', run_replay: 'Replay', run_report: 'Report', run_sealed: 'sealed', replay_stop: 'Back to live', replay_play: 'Play', replay_pause: 'Pause', replay_time: 'Time of the replay',
  layer_mosaic: 'Mosaic', layer_dose: 'Dose map', layer_cordons: 'Cordons', layer_plume: 'Gas', layer_zones: 'Threat zones', layer_routes: 'Planned routes', layer_drive: 'Drive, planned', layer_tracks: 'Flown tracks', layer_footprints: 'Footprints', layer_region: 'Region', layer_exclusions: 'Exclusions', layer_sources: 'Sources, 95 %', layer_homes: 'Homes', layer_marks: 'Marks', layer_contact: 'Contact: who hears whom', layer_grid: 'Grid', layer_base: 'Base map',
  legend: 'Dose rate, µSv/h', legend_gas: 'Gas, ppm', decisions: 'What was decided',
  help_title: 'Keys', help: 'h\tHold\nr\tResume\nb\tReturn\nl\tLand\np\tPlan anew\nEnter\tConfirm\nEsc\tCancel\na\tSeen\nt\tTheme\n1 2 3\tViews\nf\tShow all\ng\tGo to a place\n?\tKeys\nmap\tarrows, + and -, Enter chooses its middle\nc\tclose the ring that is drawn, Backspace takes back its last corner',
  link_make: 'Address for QGIS', draft_title: 'New mission', draft_start: 'Begin with', draft_region: 'Draw the region', draft_exclusion: 'Draw an exclusion', draft_home: 'Set a home', draft_done: 'Close the ring', draft_undo: 'Undo', draft_import: 'Import a region (GeoJSON, KML, QGroundControl, CSV)',
  draft_save: 'Check', draft_plan: 'Plan', draft_preflight: 'Preflight', draft_approve: 'I approve this plan', draft_launch: 'Launch', draft_area: '{area} m², {count} corners', draft_running: 'working …', draft_name: 'Name', draft_text: 'Scenario', draft_fault_line: 'line {line}',
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
  outcome_done: 'done', outcome_refused: 'refused', outcome_silent: 'no answer', outcome_stale: 'state has changed',
  critical: 'critical', warning: 'warning', refused: 'Refused: {why}',
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
