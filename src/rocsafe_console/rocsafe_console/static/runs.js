// SPDX-License-Identifier: Apache-2.0
// The runs in the folder, and the replay of a finished one on the same map.
import { t, told } from './texts.js';
import { doseRate, make, missionClock } from './format.js';
import { ask } from './link.js';
import { worldOf } from './map.js';
import { STATES, orderText } from './facts.js';
import { jobButton } from './jobs.js';

const SPEED = 8;
const SHOWN_EVENTS = 40;
const SEVERITIES = ['', 'warning', 'critical'];
// Layers whose pictures are those of the live mission, or of the replay.
const IMAGES = ['mosaic', 'dose', 'plume'];

export class Runs {
  constructor(panel, bar, map) {
    this.panel = panel;
    this.bar = bar;
    this.map = map;
  }

  async show() {
    const may = this.map.link.sections.session?.may ?? [];
    const [{ runs }, { campaigns }] = await Promise.all([ask('/api/runs'), may.includes('draft') ? ask('/api/campaigns') : { campaigns: [] }]);
    const address = make('output', { class: 'note' });
    const link = make('button', { type: 'button', class: 'small', text: t('link_make'), onclick: async () => { address.textContent = (await ask('/api/links', {})).url; } });
    const rows = runs.map((run) => this.row(run, may));
    this.events = make('ul', { class: 'decisions', tabindex: 0, 'aria-label': t('replay_events') });
    this.eventBox = make('section', { class: 'fact', hidden: !this.run }, make('h2', { text: t('replay_events') }), this.events);
    this.panel.replaceChildren(this.eventBox, make('h2', { text: t('runs_title') }), make('p', { class: 'run-buttons' }, link), address,
      rows.length ? make('ul', { class: 'run-list' }, ...rows) : make('p', { class: 'none', text: t('runs_none') }),
      ...(may.includes('launch') ? this.campaigns(campaigns) : []), ...(may.includes('clear') ? this.clean() : []));
  }

  // A mission: its state, who commands it, who sees it, and what can be done with it.
  row(run, may) {
    const box = make('div', { class: 'job-box' });
    const nameOf = () => run.name;
    const words = [run.outcome, run.is_sealed ? t('run_sealed') : '', run.commander ? t('commanded_by', { name: run.commander }) : t('commanded_by_nobody'),
      run.members.length ? t('access_list', { names: run.members.join(', ') }) : t('access_open'), run.visibility === 'named' ? t('access_named_short') : ''];
    const button = (key, onclick) => make('button', { type: 'button', class: 'small', text: t(key), onclick });
    return make('li', { class: 'run', 'data-run': run.name },
      make('b', { text: run.name }),
      make('span', { class: 'note', text: words.filter(Boolean).join(' · ') }),
      make('span', { class: 'run-buttons' },
        button('run_replay', () => this.replay(run.name)),
        button('run_verify', (event) => this.verify(run.name, event.target)),
        run.has_report ? make('a', { class: 'link', href: `/api/runs/${encodeURIComponent(run.name)}/files/report.html`, target: '_blank', rel: 'noopener', text: t('run_report') }) : '',
        may.includes('assign') ? button('access', () => this.askAccess(run)) : '',
        may.includes('seal') ? button('run_seal', (event) => this.seal(run.name, event.target)) : '',
        may.includes('resume_run') && run.can_resume ? jobButton('resume', nameOf, box) : '',
        may.includes('remake') ? jobButton('report', nameOf, box) : '',
        may.includes('remake') ? jobButton('replay', nameOf, box) : ''),
      make('output', { class: 'note run-word' }), box);
  }

  campaigns(names) {
    if (!names.length) return [make('h2', { text: t('campaigns') }), make('p', { class: 'none', text: t('campaigns_none') })];
    const box = make('div', { class: 'job-box' });
    const choice = make('select', { 'aria-label': t('campaigns'), id: 'campaign' }, ...names.map((name) => make('option', { value: name, text: name })));
    const page = make('button', { type: 'button', class: 'small', text: t('campaign_page'), onclick: () => open(`/api/campaigns/${encodeURIComponent(choice.value)}/page`, '_blank', 'noopener') });
    return [make('h2', { text: t('campaigns') }), make('p', { class: 'run-buttons' }, choice, jobButton('campaign', () => choice.value, box), page), box];
  }

  clean() {
    const box = make('div', { class: 'job-box' });
    const name = make('input', { id: 'clear-name', maxlength: 60 });
    return [make('h2', { text: t('clear_title') }), make('label', { for: 'clear-name', text: t('clear_label') }), make('p', { class: 'run-buttons' }, name, jobButton('clear', () => name.value, box)), box];
  }

  // Who commands a mission, who sees it, and who gives orders.
  askAccess(run) {
    const dialog = document.getElementById('access');
    const user = this.map.link.sections.session?.user ?? '';
    const commander = make('input', { id: 'access-commander', maxlength: 32, value: run.commander });
    const option = (value) => make('option', { value, text: t(`access_${value}`), selected: run.visibility === value });
    const visibility = make('select', { id: 'access-visibility' }, option('everybody'), option('named'));
    const members = make('input', { id: 'access-members', maxlength: 2000, value: run.members.join(', ') });
    const word = make('p', { class: 'warn', role: 'alert' });
    const save = async (event) => {
      event.preventDefault();
      const names = members.value.split(',').map((name) => name.trim()).filter(Boolean);
      try {
        await ask(`/api/runs/${encodeURIComponent(run.name)}/access`, { commander: commander.value.trim(), visibility: visibility.value, members: names });
        dialog.close();
        await this.show();
      } catch (error) { word.textContent = error.message; }
    };
    const field = (input, key) => [make('label', { for: input.id, text: t(key) }), input];
    dialog.replaceChildren(make('h2', { id: 'access-title', text: t('access_title', { run: run.name }) }),
      make('form', { onsubmit: save }, ...field(commander, 'access_commander'),
        make('button', { type: 'button', class: 'small', text: t('access_take'), onclick: () => { commander.value = user; } }),
        ...field(visibility, 'access_visibility'), ...field(members, 'access_members'), word,
        make('p', { class: 'run-buttons' }, make('button', { class: 'order', text: t('access_save') }), make('button', { type: 'button', class: 'small', text: t('close'), onclick: () => dialog.close() }))));
    dialog.showModal();
  }

  // Hashes all files of a run, which takes seconds.
  async verify(name, button) {
    await this.told(button, async () => {
      const { faults, seal, signer, notes } = await ask(`/api/runs/${encodeURIComponent(name)}/verify`);
      const whole = `${t('run_whole', { seal })}, ${[signer ? t('run_signed', { signer }) : t('run_unsigned'), ...notes].join('; ')}`;
      return faults.length ? t('run_changed', { what: faults.map(told).join('; ') }) : whole;
    });
  }

  async seal(name, button) {
    await this.told(button, async () => t('run_new_seal', await ask(`/api/runs/${encodeURIComponent(name)}/seal`, {})));
  }

  async told(button, work) {
    const word = button.closest('.run').querySelector('.run-word');
    word.textContent = t('run_working');
    button.disabled = true;
    word.textContent = await work().catch((error) => error.message);
    button.disabled = false;
  }

  async replay(name) {
    const run = await ask(`/api/runs/${encodeURIComponent(name)}/replay`);
    // Where a vehicle was, second by second; without a recording, where it measured.
    this.places = { ...run.series, ...run.tracks };
    const names = Object.keys(this.places).sort(new Intl.Collator('en', { numeric: true }).compare);
    const vehicles = new Map(names.map((vehicle, number) => [vehicle, { name: vehicle, rank: number, facts: { number, home: null }, frame: { state: 0 } }]));
    this.told = toldOf(run.evidence);
    this.run = run;
    this.map.source = { vehicles, tracks: new Map(), sections: { scale: this.map.link.sections.scale, ...staticSections(run) } };
    this.map.images = {};
    for (const group of IMAGES) this.map.groups[group].clearLayers();
    this.map.isFitted = false;
    this.map.drawSections(null);
    if (!this.map.isFitted) this.fitTracks();
    if (run.tiles) this.showTiles(name, run.tiles);
    this.makeBar();
    document.documentElement.dataset.replay = '1';
    document.getElementById('replay-mark').hidden = false;
    document.getElementById('place').hidden = true;
    this.onChange?.();
    if (this.eventBox) this.eventBox.hidden = false;
    this.seek(run.end_s - run.begin_s);
  }

  // Only tiles that there are: a tile of a low zoom would ask for thousands.
  showTiles(name, { zooms, columns, rows }) {
    const zoom = zooms.at(-1);
    const place = (x, y) => this.map.map.unproject([x * 256, y * 256], zoom);
    const bounds = window.L.latLngBounds(place(columns[0], rows[1] + 1), place(columns[1] + 1, rows[0]));
    const url = `/api/runs/${encodeURIComponent(name)}/files/map/tiles/{z}/{x}/{y}.png`;
    const inside = bounds.pad(-1e-6);
    this.map.groups.mosaic.addLayer(window.L.tileLayer(url, { pane: 'images', minZoom: zooms[0] - 4, maxZoom: 24, minNativeZoom: zooms[0], maxNativeZoom: zoom, bounds: inside }));
  }

  bounds() {
    const points = Object.values(this.run.series).flatMap((one) => one.latitude_deg.map((value, index) => [value, one.longitude_deg[index]]));
    return points.length ? window.L.latLngBounds(points).pad(0.5) : undefined;
  }

  fitTracks() {
    const bounds = this.bounds();
    if (bounds) this.map.map.fitBounds(bounds, { animate: false });
  }

  makeBar() {
    const length = Math.max(Math.round(this.run.end_s - this.run.begin_s), 1);
    this.slider = make('input', { type: 'range', min: 0, max: length, step: 1, value: length, 'aria-label': t('replay_time'), oninput: () => this.seek(Number(this.slider.value)) });
    this.play = make('button', { type: 'button', class: 'small', text: t('replay_play'), onclick: () => this.toggle() });
    this.time = make('output', {});
    const stop = make('button', { type: 'button', class: 'small', text: t('replay_stop'), onclick: () => this.stop() });
    this.bar.replaceChildren(make('b', { text: this.run.name }), this.play, this.slider, this.time, stop);
    this.bar.hidden = false;
  }

  toggle() {
    this.isPlaying = !this.isPlaying;
    this.play.textContent = t(this.isPlaying ? 'replay_pause' : 'replay_play');
    if (this.isPlaying && Number(this.slider.value) >= Number(this.slider.max)) this.seek(0);
    let before = performance.now();
    const step = (now) => {
      if (!this.isPlaying) return;
      this.seek(this.at + ((now - before) / 1000) * SPEED);
      before = now;
      if (this.at >= Number(this.slider.max)) { this.toggle(); return; }
      requestAnimationFrame(step);
    };
    if (this.isPlaying) requestAnimationFrame(step);
  }

  seek(seconds) {
    this.at = Math.min(Math.max(seconds, 0), Number(this.slider.max));
    this.slider.value = this.at;
    const until = this.run.begin_s + this.at;
    let highest = NaN;
    this.map.tracks.clear();
    for (const [name, one] of Object.entries(this.places)) {
      const series = this.run.series[name] ?? { time_s: [] };
      const measured = series.time_s.length ? this.worlds(name, series).slice(0, upTo(series.time_s, until)) : this.worlds(name, one).slice(0, upTo(one.time_s, until));
      this.map.tracks.set(name, measured);
      for (const point of measured) if (!(point[2] <= highest)) highest = point[2];
      const vehicle = this.map.source.vehicles.get(name);
      const at = upTo(one.time_s, until) - 1;
      [vehicle.frame.latitude, vehicle.frame.longitude] = [one.latitude_deg[at], one.longitude_deg[at]];
      vehicle.world = worldOf(vehicle.frame.latitude, vehicle.frame.longitude);
      vehicle.frame.state = 0;
    }
    this.tellUntil(until);
    this.time.textContent = `${missionClock(this.at)} · ${doseRate(highest)}`;
    this.map.trackLayer.redraw();
    this.map.schedule();
  }

  // States of the vehicles, and what was decided and stored until a moment.
  tellUntil(until) {
    const past = this.told.filter((one) => one.time_s <= until);
    for (const one of past) {
      const vehicle = one.state === undefined ? null : this.map.source.vehicles.get(one.by);
      if (vehicle) vehicle.frame.state = one.state;
    }
    if (!this.events) return;
    const rows = past.slice(-SHOWN_EVENTS).reverse().map((one) => make('li', { class: one.severity }, make('span', { class: 'note', text: [missionClock(one.time_s - this.run.begin_s), one.text.startsWith(`${one.by}:`) ? '' : one.by, ''].join(' ') }), told(one.text)));
    this.events.replaceChildren(...(rows.length ? rows : [make('li', { class: 'none', text: t('replay_none') })]));
  }

  worlds(name, one) {
    this.cache ??= new Map();
    const key = `${this.run.name}/${name}`;
    if (!this.cache.has(key)) this.cache.set(key, one.latitude_deg.map((latitude, index) => [...worldOf(latitude, one.longitude_deg[index]), one.dose_rate_usvh?.[index] ?? NaN]));
    return this.cache.get(key);
  }

  stop() {
    this.isPlaying = false;
    this.run = null;
    this.bar.hidden = true;
    delete document.documentElement.dataset.replay;
    document.getElementById('replay-mark').hidden = true;
    if (this.eventBox) this.eventBox.hidden = true;
    this.map.source = null;
    this.map.images = {};
    for (const group of IMAGES) this.map.groups[group].clearLayers();
    this.map.trackLayer.redraw();
    this.map.isFitted = false;
    this.map.drawSections(null);
    this.map.schedule();
    this.onChange?.();
  }
}

// Number of times up to a moment, at least one.
function upTo(times, until) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= until) low = middle + 1; else high = middle;
  }
  return Math.max(low, 1);
}

// What the log of a run tells at times of the mission: [{time_s, by, text, severity, state}].
// An order of a person has the time on the wall; the line before it in the log has the mission's.
function toldOf(evidence) {
  const verbs = new Map(evidence.filter((one) => one.kind === 'order' && one.verb).map((one) => [one.request_id, one.verb]));
  let now = 0;
  return evidence.map(({ kind, by, message, request_id: id, results, text }) => {
    if (kind === 'outcome' && verbs.has(id)) return { time_s: now, by, severity: '', text: orderText(verbs.get(id), Object.fromEntries(results.map((one) => [one.vehicle, one.outcome]))) };
    if (kind === 'mark') return { time_s: now, by, severity: '', text: `${t('verb_mark')}: ${text || '–'}` };
    if (!message?.header) return { time_s: 0 };
    const { sec, nanosec } = message.header.stamp;
    now = Math.max(now, sec + nanosec / 1e9);
    const told = { time_s: sec + nanosec / 1e9, by, text: [message.text, message.reason].filter(Boolean).join(': '), severity: kind === 'decision' ? SEVERITIES[message.severity] : '' };
    if (kind === 'state') return { ...told, state: message.state, text: t('event_state', { vehicle: by, state: t(`state_${STATES[message.state] ?? 'unknown'}`) }) };
    if (kind === 'photograph') return { ...told, text: t('event_photograph', { vehicle: message.vehicle, shot: message.shot_id }) };
    if (kind === 'alarm') return { ...told, severity: 'warning', text: `${message.name}: ${doseRate(message.value_usv)}` };
    return told;
  }).filter((one) => one.time_s > 0 && one.text).sort((a, b) => a.time_s - b.time_s);
}

// GeoJSON of the files of a run as the sections of a live one.
function staticSections(run) {
  const turn = (ring) => ring.map(([longitude, latitude]) => [latitude, longitude]);
  const features = run.plan?.features ?? [];
  const polygons = (kind) => features.filter((one) => one.properties.kind === kind).map((one) => one.geometry.coordinates.map(turn));
  const routes = {};
  for (const one of features) if (one.properties.kind === 'route' && one.geometry.type === 'LineString') routes[one.properties.vehicle] = { line: turn(one.geometry.coordinates), viewpoints: [] };
  const [region] = polygons('region');
  const cordons = (run.cordons?.features ?? []).flatMap((one) => {
    const parts = one.geometry.type === 'MultiPolygon' ? one.geometry.coordinates : [one.geometry.coordinates];
    return parts.flat().map((ring) => ({ level_usvh: one.properties.level_usv_h, is_mean: one.properties.confidence === 'mean', ring: turn(ring) }));
  });
  const sources = (run.sources?.features ?? []).filter((one) => one.geometry.type === 'Point').map((one, index) => ({ id: one.properties.source ?? index + 1, place: turn([one.geometry.coordinates])[0], half_axes_m: one.properties.ellipse_95_m ?? [1, 1], angle_deg: one.properties.ellipse_angle_from_east_deg ?? 0 }));
  return { region: region ? { rings: region } : undefined, plan: { routes, exclusions: polygons('exclusion') }, cordons, sources: { sources } };
}
