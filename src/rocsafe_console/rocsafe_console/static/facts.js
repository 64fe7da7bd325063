// SPDX-License-Identifier: Apache-2.0
// The ten facts that an incident commander asks for, in their order.
import { t, told } from './texts.js';
import { age, dose, doseRate, duration, figures, isNumber, make, missionClock, percent, placeText } from './format.js';
import { colourOf, worldOf } from './map.js';
import { STALE_S } from './link.js';

export const STATES = ['unknown', 'disarmed', 'armed', 'taking_off', 'flying', 'holding', 'returning', 'landing', 'landed', 'lost', 'crashed', 'waiting'];
const SHAPES = { holding: '■', returning: '▼', landing: '▼', lost: '✕', crashed: '✕', flying: '●', taking_off: '▲' };
const IN_THE_AIR = new Set(['taking_off', 'flying', 'holding', 'returning', 'landing']);
// The same states on wheels.
const ON_WHEELS = { disarmed: 'parked', flying: 'driving', holding: 'standing', landed: 'arrived' };
// Beside each other where there is room, so that all ten are seen at a glance; else one after the
// other. What was decided is no fact, and lies below them.
const COLUMNS = [['alarms', 'worst', 'sources', 'zones'], ['coverage', 'picture', 'camera', 'vehicles'], ['decisions']];
// Rows that are made in one go: the page answers between them.
const ROWS_AT_ONCE = 12;
// Vehicles of an order that are named.
const MOST_NAMED = 5;
// A wind that was measured longer ago is not the wind now.
const WIND_OLD_S = 10;
// Photographs come each some seconds, estimates each 5 s or as fast as they can be computed.
const PICTURE_OLD_S = 30;
const ESTIMATE_OLD_S = 60;
const M_PER_WORLD = 40075016;

// Replaces only what differs, so that nothing flickers, and a press or the focus of a key stays.
export function fill(element, ...children) {
  merge(element, children.flat().filter(Boolean).map((child) => (child.nodeType ? child : document.createTextNode(child))));
}

function merge(parent, next) {
  const before = [...parent.childNodes];
  next.forEach((node, index) => {
    const old = before[index];
    if (!old) parent.append(node);
    else if (old === node || old.isEqualNode(node)) return;
    else if (isSameKind(old, node)) merge(old, [...node.childNodes]);
    else {
      const hasFocus = old === document.activeElement;
      old.replaceWith(node);
      if (hasFocus) node.focus?.();
    }
  });
  for (const old of before.slice(next.length)) if (!next.includes(old)) old.remove();
}

// A button is replaced as a whole: what it does belongs to its text.
const isSameKind = (old, node) => old.nodeType === Node.ELEMENT_NODE && old.tagName === node.tagName && old.tagName !== 'BUTTON' && old.cloneNode(false).isEqualNode(node.cloneNode(false));

export class Facts {
  constructor(element, link, actions) {
    this.link = link;
    this.actions = actions;
    this.boxes = {};
    for (const names of COLUMNS) {
      const column = make('div', { class: 'fact-column' });
      for (const name of names) {
        const title = name === 'decisions' ? t('decisions') : t(`fact_${name}`);
        const body = make('div', { class: 'fact-body' });
        this.boxes[name] = body;
        column.append(make('section', { class: `fact fact-${name}`, 'aria-labelledby': `fact-${name}` }, make('h2', { id: `fact-${name}`, text: title }), body));
      }
      element.append(column);
    }
    this.rows = new Map();
    // Alarms at once, all else twice a second: 300 vehicles are told as often as that.
    link.addEventListener('sections', ({ detail }) => { if (detail.isHello) this.draw(); else if (detail.names.includes('alarms')) this.drawAlarms(link.sections.alarms ?? []); });
    setInterval(() => this.draw(), 500);
    // Only the rows that can be seen are drawn.
    this.watch = new IntersectionObserver((entries) => { for (const entry of entries) entry.target.isSeen = entry.isIntersecting; });
  }

  draw() {
    const { sections } = this.link;
    this.drawWorst(sections.dose, sections.gas ?? []);
    this.drawSources(sections.sources, sections.releases);
    this.drawZones(sections);
    this.drawCoverage(sections.progress, sections.plan, sections.mission);
    this.drawPicture(sections.photograph, sections.mosaic);
    this.drawAlarms(sections.alarms ?? []);
    this.drawVehicles(sections.vehicle_facts ?? {});
    this.drawDecisions(sections.decisions ?? []);
  }

  // Age by the clock of the server; what is old is grey, and says so.
  ageMark(heard, limit = STALE_S) {
    const seconds = isNumber(heard) ? this.link.now - heard : Infinity;
    const isOld = !this.link.isLive || !(Number.isFinite(seconds) && seconds <= limit);
    const text = isNumber(seconds) && seconds < 1e9 ? t('ago', { age: age(Math.max(seconds, 0)) }) : t('stale');
    return [make('span', { class: isOld ? 'age old' : 'age', text }), isOld];
  }

  // A button that shows a place on the map.
  lookButton(latitude, longitude, text) {
    return make('button', { type: 'button', class: 'link', 'data-place': `${latitude},${longitude}`, onclick: () => this.actions.look(latitude, longitude), text });
  }

  // The worst gas reading of each unit; a mission may measure dose, gas or both.
  gasLines(gas) {
    return gas.flatMap(({ unit, worst, newest }) => {
      const [mark, isOld] = this.ageMark(newest.heard_s);
      const words = (one) => (one.is_below_limit ? t('below_limit') : `${one.is_saturated ? '≥ ' : ''}${t('gas_reading', { value: figures(one.value), unit })}`);
      const place = this.lookButton(worst.latitude_deg, worst.longitude_deg, placeText(worst.forms));
      return [make('h3', { text: t('fact_gas') }), make('p', { class: isOld ? 'big second grey' : 'big second', text: words(worst) }),
        make('p', { class: lineOf(isOld) }, `${t('by_at', { vehicle: worst.vehicle, detector: [worst.sensor, worst.calibration_gas].filter(Boolean).join(', ') })} `, isNumber(worst.latitude_deg) ? place : '', ' ', this.ageMark(worst.heard_s, Infinity)[0]),
        make('p', { class: lineOf(isOld) }, `${t('fact_now')}: `, make('strong', { text: words(newest) }), ` ${newest.vehicle} `, mark)];
    });
  }

  drawWorst(value, gas) {
    const { worst, newest, trend } = value ?? {};
    if (!worst && gas.length) { fill(this.boxes.worst, ...this.gasLines(gas)); return; }
    if (!worst) { fill(this.boxes.worst, make('p', { class: 'none', text: t('no_reading') })); return; }
    const [mark, isOld] = this.ageMark(newest.heard_s);
    const now = make('p', { class: lineOf(isOld) }, `${t('fact_now')}: `, make('strong', { text: doseRate(newest.dose_rate_usvh) }), ` ${newest.vehicle} `, trend ? make('span', { text: `${{ rising: '↗', falling: '↘', steady: '→' }[trend]} ${t(`trend_${trend}`)} ` }) : '', mark);
    const place = this.lookButton(worst.latitude_deg, worst.longitude_deg, placeText(worst.forms));
    const [worstMark] = this.ageMark(worst.heard_s, Infinity);
    fill(this.boxes.worst,
      make('p', { class: isOld ? 'big grey' : 'big', text: doseRate(worst.dose_rate_usvh) }),
      make('p', { class: lineOf(isOld) }, `${t('by_at', { vehicle: worst.vehicle, detector: worst.detector })} `, isNumber(worst.latitude_deg) ? place : '', ' ', worstMark, worst.is_saturated ? make('span', { class: 'warn', text: ` ${t('saturated')}` }) : ''),
      now, ...this.gasLines(gas));
  }

  drawSources(value, gas) {
    const [mark, isOld] = this.ageMark(value?.heard_s, ESTIMATE_OLD_S);
    const [gasMark, isGasOld] = this.ageMark(gas?.heard_s, ESTIMATE_OLD_S);
    const list = (value?.sources ?? []).map((source) => {
      const size = figures(source.half_axes_m.every(isNumber) ? Math.max(...source.half_axes_m) : NaN, 2);
      return make('li', { class: lineOf(isOld) }, this.lookButton(...source.place, t('source_name', { id: source.id })), ` ${t('source_line', { strength: doseRate(source.dose_rate_at_1m_usvh), size, probability: source.probability })}${source.nuclide ? `, ${source.nuclide}` : ''}`, source.forms ? make('span', { class: 'note', text: ` ${placeText(source.forms)}` }) : '');
    });
    for (const one of gas?.releases ?? []) {
      const line = t('release_line', { low: figures(one.rate_low, 2), high: figures(one.rate_high, 2), unit: gas.rate_unit, agent: gas.agent, size: figures(one.radius_95_m, 2) });
      list.push(make('li', { class: lineOf(isGasOld) }, this.lookButton(...one.place, t('release_name', { id: one.id })), ` ${line}`));
    }
    const doubts = (value?.doubts ?? []).map((text) => make('li', { class: 'warn', text: told(text) }));
    fill(this.boxes.sources, list.length ? make('ul', {}, ...list, ...doubts) : make('p', { class: 'none', text: t(value || gas ? 'no_source' : 'no_estimate') }), value?.verdict ? make('p', { class: 'note' }, told(value.verdict), ' ', mark) : '', gas?.verdict ? make('p', { class: 'note' }, t('gas_verdict', { text: told(gas.verdict) }), ' ', gasMark) : '');
  }

  drawZones({ cordons, wind, zones: gas, releases, cordons_heard_s: heard, zones_heard_s: gasHeard }) {
    const zones = new Map();
    for (const one of cordons ?? []) {
      const key = `${one.level_usvh} ${one.is_mean}`;
      const before = zones.get(key);
      const radius = radiusOf(one.ring);
      if (!before || before.radius < radius) zones.set(key, { ...one, radius });
    }
    const [mark, isOld] = this.ageMark(Math.min(cordons?.length ? heard ?? -Infinity : Infinity, gas?.length ? gasHeard ?? -Infinity : Infinity), ESTIMATE_OLD_S);
    const rows = [...zones.values()].filter((one) => !one.is_mean).sort((a, b) => b.level_usvh - a.level_usvh)
      .map((one) => make('li', { text: t('zone_line', { level: doseRate(one.level_usvh), radius: figures(one.radius, 2) }) }));
    rows.push(...gasZones(gas ?? [], releases?.releases?.[0]?.place));
    const list = rows.length ? make('ul', { class: lineOf(isOld) }, ...rows, make('li', { class: 'note' }, `${t('zone_upper')} `, mark)) : make('p', { class: 'none', text: t(cordons || gas ? 'no_zone' : 'no_estimate') });
    let line = make('p', { class: 'none', text: t('no_wind') });
    if (wind) {
      const arrow = make('span', { class: 'wind-arrow', text: '↓', 'aria-hidden': 'true' });
      arrow.style.transform = `rotate(${wind.from_deg}deg)`;
      const from = `${Math.round(wind.from_deg)}`;
      const [windMark, isWindOld] = this.ageMark(wind.heard_s, WIND_OLD_S);
      line = make('p', { class: lineOf(isWindOld) }, arrow, ` ${t('wind_line', { from, speed: figures(wind.speed_mps, 2) })} (${compassOf(wind.from_deg)}), ${t('wind_by', { vehicle: wind.vehicle })}. ${t('access_line', { side: compassOf(wind.from_deg) })} `, windMark);
    }
    fill(this.boxes.zones, list, make('h3', { text: t('fact_wind') }), line);
  }

  drawCoverage(progress, plan, mission) {
    // Without cameras it is the viewpoints that count.
    const [done, all] = progress?.images_expected ? [progress.images_stored, progress.images_expected] : [progress?.visited, progress?.viewpoints];
    const fraction = all ? done / all : NaN;
    const meter = make('div', { class: 'meter', role: 'img', 'aria-label': percent(fraction) }, make('span'));
    meter.firstChild.style.width = `${isNumber(fraction) ? 100 * Math.min(fraction, 1) : 0}%`;
    const planned = plan ? t('time_line', { planned: duration(plan.makespan_s), bound: duration(plan.lower_bound_s) }) : t('no_plan');
    fill(this.boxes.coverage,
      make('p', { class: 'big', text: percent(fraction) }), meter,
      make('p', { class: 'line', text: progress ? t(progress.images_expected ? 'coverage_line' : 'coverage_visited', { stored: done, expected: all }) : t('no_mission') }),
      make('h3', { text: t('fact_time') }),
      make('p', { class: 'line' }, make('strong', { text: duration(progress?.left_s) }), ` ${planned}`),
      make('p', { class: 'report' }, reportOf(mission)));
  }

  drawPicture(photograph, mosaic) {
    const parts = [];
    if (photograph) {
      const url = `/api/photograph/${encodeURIComponent(photograph.shot_id)}`;
      if (this.pictureUrl !== url) { this.pictureUrl = url; this.picture = make('img', { src: url, alt: photograph.shot_id, class: 'newest', loading: 'lazy' }); }
      const [mark, isOld] = this.ageMark(photograph.heard_s, PICTURE_OLD_S);
      this.picture.classList.toggle('old-picture', isOld);
      parts.push(this.picture, make('p', { class: lineOf(isOld) }, `${photograph.shot_id} `, mark));
    } else parts.push(make('p', { class: 'none', text: t('no_picture') }));
    if (mosaic) {
      const [mark, isOld] = this.ageMark(mosaic.heard_s, ESTIMATE_OLD_S);
      const size = isNumber(mosaic.ground_resolution_m) && mosaic.ground_resolution_m > 0 ? figures(mosaic.ground_resolution_m, 2) : '–';
      parts.push(make('p', { class: lineOf(isOld) }, `${t('fact_mosaic')}: ${t('mosaic_line', { count: mosaic.images_placed, resolution: size })}, ${t(mosaic.is_final ? 'mosaic_final' : 'mosaic_draft')} `, mark));
    }
    fill(this.boxes.picture, ...parts);
  }

  drawAlarms(alarms) {
    const open = alarms.filter((alarm) => !alarm.seen_by).reverse().sort((a, b) => Number(b.severity === 'critical') - Number(a.severity === 'critical'));
    const seen = alarms.filter((alarm) => alarm.seen_by).reverse().slice(0, 5);
    const row = (alarm) => make('li', { class: `alarm ${alarm.severity}${alarm.seen_by ? ' seen' : ''}` },
      make('span', { class: 'sign', text: alarm.severity === 'critical' ? '▲' : '●', 'aria-hidden': 'true' }),
      make('span', { class: 'alarm-text' }, make('strong', { text: `${t(alarm.severity)}: ` }), told(alarm.text), ' ', this.ageMark(alarm.time_s, Infinity)[0]),
      alarm.seen_by ? make('span', { class: 'note', text: t('seen_by', { who: alarm.seen_by }) }) : make('button', { type: 'button', class: 'small', 'data-alarm': alarm.number, text: t('acknowledge'), onclick: () => this.actions.acknowledge(alarm.number) }));
    // Ages change each second: the list is made again only if the alarms differ, or once in five.
    const key = `${open.map((one) => one.number)}|${seen.map((one) => one.number)}|${Math.floor(this.link.now / 5)}`;
    if (this.alarmKey === key) return;
    this.alarmKey = key;
    const focused = document.activeElement?.dataset?.alarm;
    this.boxes.alarms.replaceChildren(open.length + seen.length ? make('ul', { class: 'alarms' }, ...open.map(row), ...seen.map(row)) : make('p', { class: 'none', text: t('no_alarm') }));
    if (focused) this.boxes.alarms.querySelector(`[data-alarm="${CSS.escape(focused)}"]`)?.focus();
    document.getElementById('fact-alarms').dataset.open = open.length;
  }

  drawVehicles(facts) {
    const box = this.boxes.vehicles;
    if (!this.link.vehicles.size) { fill(box, make('p', { class: 'none', text: t('no_vehicle') })); this.rows.clear(); return; }
    if (!this.rows.size) { box.replaceChildren(this.fleet = make('p', { class: 'line fleet' }), this.list = make('ul', { class: 'vehicles' })); }
    fill(this.fleet, ...this.fleetWords(facts));
    for (const name of this.rows.keys()) if (!this.link.vehicles.has(name)) { this.watch.unobserve(this.rows.get(name)); this.rows.get(name).remove(); this.rows.delete(name); }
    let room = ROWS_AT_ONCE;
    let at = 0;
    for (const vehicle of this.link.vehicles.values()) {
      let row = this.rows.get(vehicle.name);
      if (!row && !room) { setTimeout(() => this.drawVehicles(this.link.sections.vehicle_facts ?? {}), 0); break; }
      if (!row) { room -= 1; row = this.makeRow(vehicle); this.rows.set(vehicle.name, row); this.list.insertBefore(row, this.list.children[at] ?? null); this.watch.observe(row); }
      at += 1;
      row.classList.toggle('grey', this.link.isStale(vehicle));
      if (row.isSeen !== false) this.drawRow(row, vehicle, facts[vehicle.name] ?? {});
    }
  }

  // The fleet in a line, for more vehicles than can be seen at once: the worst of each fact.
  fleetWords(facts) {
    const all = [...this.link.vehicles.values()];
    const heard = all.filter((one) => !this.link.isStale(one));
    const counts = new Map();
    for (const one of heard) {
      const state = wordOf(one);
      counts.set(state, (counts.get(state) ?? 0) + 1);
    }
    const words = [...counts].sort((a, b) => b[1] - a[1]).map(([state, count]) => `${count} ${t(`state_${state}`)}`).join(', ');
    const worst = (key, valueOf, of) => {
      const known = of.map((one) => [valueOf(one), one.name]).filter(([value]) => isNumber(value)).sort((a, b) => b[0] - a[0]);
      return known.length ? t(key, { vehicle: known[0][1], value: key === 'fleet_dose' ? dose(known[0][0]) : duration(Math.abs(known[0][0])) }) : '';
    };
    const margin = ({ name }) => -Math.max((facts[name]?.battery_left_s ?? NaN) - (facts[name]?.way_home_s ?? NaN), 0);
    const parts = [words, worst('fleet_turn', margin, heard.filter((one) => IN_THE_AIR.has(stateOf(one)))), worst('fleet_link', (one) => this.link.ageOf(one), all), worst('fleet_dose', ({ name }) => facts[name]?.dose_usv, all)].filter(Boolean);
    const silent = all.length - heard.length;
    return [silent ? make('strong', { class: 'old', text: t('fleet_stale', { count: silent }) }) : '', `${silent ? ' ' : ''}${parts.join(' · ')}`];
  }

  makeRow(vehicle) {
    const box = make('input', { type: 'checkbox', id: `pick-${vehicle.name}`, onchange: () => this.actions.select(vehicle.name, box.checked) });
    const stripe = make('span', { class: 'stripe', 'aria-hidden': 'true' });
    const name = make('label', { class: 'vehicle-name', for: `pick-${vehicle.name}`, text: vehicle.name });
    return make('li', { class: 'vehicle' }, stripe, make('div', { class: 'vehicle-head' }, box, name, make('span', { class: 'state' })), make('div', { class: 'vehicle-facts' }), make('div', { class: 'vehicle-text' }));
  }

  drawRow(row, vehicle, facts) {
    const frame = vehicle.frame;
    const isStale = this.link.isStale(vehicle);
    const shown = [vehicle.rank, vehicle.facts.revision, vehicle.facts.text, vehicle.facts.holder, frame?.battery, frame?.flags, isStale, Math.round(this.link.ageOf(vehicle)), this.actions.isSelected(vehicle.name), contactLine(this.link.sections.contacts?.[vehicle.name], this.link.now), Object.values(facts)].join();
    if (row.shown === shown) return;
    row.shown = shown;
    row.querySelector('.stripe').style.background = colourOf(vehicle.rank);
    const state = stateOf(vehicle);
    row.classList.toggle('bad', state === 'lost' || state === 'crashed');
    row.querySelector('input').checked = this.actions.isSelected(vehicle.name);
    const heard = this.link.ageOf(vehicle);
    const seconds = heard === Infinity ? t('never') : age(Math.round(heard));
    fill(row.querySelector('.state'), `${SHAPES[state] ?? '○'} ${t(`state_${wordOf(vehicle)}`)}`, vehicle.facts.taken_by ? make('strong', { class: 'warn', text: ` ${t('taken_by', { who: vehicle.facts.taken_by })}` }) : '', isStale ? make('strong', { class: 'old', text: ` ${t('stale')}` }) : '');
    const pair = (key, text, isOld) => make('span', { class: isOld ? 'pair grey' : 'pair', 'data-fact': key }, make('span', { class: 'key', text: key ? `${t(key)} ` : '' }), make('b', { text }), isOld ? make('span', { class: 'old', text: t('stale') }) : '');
    // What is known of the whole row need not be said of its parts.
    const [isPlaceOld, isDoseOld] = [!isStale && this.link.isPlaceOld(vehicle), !isStale && this.link.isDoseOld(vehicle)];
    fill(row.querySelector('.vehicle-facts'),
      pair('battery', percent(frame?.battery)), isNumber(facts.battery_left_s) ? pair('battery_left', duration(facts.battery_left_s)) : '',
      pair('way_home', duration(facts.way_home_s), isPlaceOld && isNumber(facts.way_home_s)), pair('link', seconds),
      pair('dose', `${facts.dose_is_lower_limit ? '≥ ' : ''}${dose(facts.dose_usv)}`, isDoseOld && isNumber(facts.dose_usv)), pair('', t('visited', { done: facts.visited ?? 0, all: vehicle.facts.viewpoint_count })));
    const holder = vehicle.facts.holder ? t('led_by', { holder: vehicle.facts.holder }) : t('led_by_nobody');
    fill(row.querySelector('.vehicle-text'), [driveLine(vehicle, this.link.sections.drive), holder, contactLine(this.link.sections.contacts?.[vehicle.name], this.link.now), isPlaceOld && isNumber(frame?.latitude) ? t('place_old') : '', vehicle.facts.is_simulated ? t('simulated') : '', told(vehicle.facts.text), vehicle.facts.advice ? t('advice', { advice: vehicle.facts.advice }) : ''].filter(Boolean).join(' · '));
  }

  drawDecisions(decisions) {
    const rows = decisions.slice(-30).reverse().map((one) => make('li', { class: one.severity }, make('span', { class: 'note', text: `${missionClock(one.wall_time_s)} ${one.by} ` }), one.verb ? orderText(one.verb, one.outcomes) : [one.text, one.reason].filter(Boolean).map(told).join(': ')));
    fill(this.boxes.decisions, rows.length ? make('ul', { class: 'decisions', tabindex: 0, 'aria-label': t('decisions') }, ...rows) : make('p', { class: 'none', text: '–' }));
  }
}

// What a person has ordered, and how many of which vehicles have done it.
export function orderText(verb, outcomes) {
  const names = Object.keys(outcomes).sort();
  const done = names.filter((name) => outcomes[name] === 'done').length;
  const text = t('sent', { verb: t(`verb_${verb}`), done, all: names.length });
  return names.length > MOST_NAMED ? text : `${text} (${names.join(', ')})`;
}

export const isOver = (mission) => ['complete', 'failed', 'cancelled'].includes(mission?.phase);
export const reportLink = (mission) => make('a', { class: 'link', href: `/api/runs/${encodeURIComponent(mission.id)}/files/report.html`, target: '_blank', rel: 'noopener', text: t('fact_report') });
// The report of a mission that has ended; before that, when there is one.
function reportOf(mission) {
  if (!isOver(mission)) return make('span', { class: 'note', text: `${t('fact_report')}: ${t('report_later')}` });
  return reportLink(mission);
}

// The eighth of the compass in which a bearing lies.
const compassOf = (degrees) => t('compass').split(' ')[Math.round(degrees / 45) % 8];

const lineOf = (isOld) => (isOld ? 'line grey' : 'line');

const stateOf = (vehicle) => STATES[vehicle.frame?.state ?? vehicle.facts.state] ?? 'unknown';
export const wordOf = (vehicle) => (vehicle.facts.is_ground && ON_WHEELS[stateOf(vehicle)]) || stateOf(vehicle);

// The planned drive of a ground vehicle: the route that it drives, else the newest offer.
function driveLine(vehicle, drive) {
  if (!vehicle.facts.is_ground || drive?.vehicle !== vehicle.name) return '';
  return t('drive_line', { time: duration(drive.duration_s), dose: dose(drive.dose_usv), upper: dose(drive.dose_upper_usv), budget: dose(drive.dose_budget_usv) });
}

// Whom its agent hears, as long as that is new.
function contactLine(contact, now) {
  if (!isNumber(contact?.heard_s) || now - contact.heard_s > STALE_S) return '';
  return contact.hears.length ? t('hears', { names: contact.hears.length > 5 ? contact.hears.length : contact.hears.join(', ') }) : t('hears_nobody');
}

// How far from the release the outer bound of each level goes.
function gasZones(zones, place) {
  const reach = new Map();
  for (const zone of zones) if (!zone.is_mean && place) reach.set(zone.level, Math.max(reach.get(zone.level) ?? 0, ...zone.ring.map((corner) => metresBetween(corner, place))));
  return [...reach].map(([level, metres]) => make('li', { text: t('gas_zone_line', { level, radius: figures(metres, 2) }) }));
}

function metresBetween(a, b) {
  const [p, q] = [worldOf(...a), worldOf(...b)];
  return M_PER_WORLD * Math.cos((a[0] * Math.PI) / 180) * Math.hypot(p[0] - q[0], p[1] - q[1]);
}

function radiusOf(ring) {
  const points = ring.map(([latitude, longitude]) => worldOf(latitude, longitude));
  const xs = points.map((p) => p[0]);
  const ys = points.map((p) => p[1]);
  const scale = M_PER_WORLD * Math.cos(((ring[0]?.[0] ?? 0) * Math.PI) / 180);
  const [x, y] = [(Math.min(...xs) + Math.max(...xs)) / 2, (Math.min(...ys) + Math.max(...ys)) / 2];
  return scale * Math.max(...points.map((p) => Math.hypot(p[0] - x, p[1] - y)));
}
