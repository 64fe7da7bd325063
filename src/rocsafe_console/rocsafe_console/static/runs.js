// SPDX-License-Identifier: Apache-2.0
// The runs in the folder, and the replay of a finished one on the same map.
import { t } from './texts.js';
import { doseRate, make, missionClock } from './format.js';
import { ask } from './link.js';
import { worldOf } from './map.js';

const SPEED = 8;
// Layers whose pictures are those of the live mission, or of the replay.
const IMAGES = ['mosaic', 'dose', 'plume'];

export class Runs {
  constructor(panel, bar, map) {
    this.panel = panel;
    this.bar = bar;
    this.map = map;
  }

  async show() {
    const { runs } = await ask('/api/runs');
    const may = this.map.link.sections.session?.may ?? [];
    const rows = runs.map((run) => make('li', { class: 'run' },
      make('b', { text: run.name }),
      make('span', { class: 'note', text: [run.outcome, run.is_sealed ? t('run_sealed') : ''].filter(Boolean).join(' · ') }),
      make('span', { class: 'run-buttons' },
        make('button', { type: 'button', class: 'small', text: t('run_replay'), onclick: () => this.replay(run.name) }),
        make('button', { type: 'button', class: 'small', text: t('run_verify'), onclick: (event) => this.verify(run.name, event.target) }),
        may.includes('seal') ? make('button', { type: 'button', class: 'small', text: t('run_seal'), onclick: (event) => this.seal(run.name, event.target) }) : '',
        run.has_report ? make('a', { class: 'link', href: `/api/runs/${encodeURIComponent(run.name)}/files/report.html`, target: '_blank', rel: 'noopener', text: t('run_report') }) : ''),
      make('output', { class: 'note run-word' })));
    const address = make('output', { class: 'note' });
    const link = make('button', { type: 'button', class: 'small', text: t('link_make'), onclick: async () => { address.textContent = (await ask('/api/links', {})).url; } });
    this.panel.replaceChildren(make('h2', { text: t('runs_title') }), make('p', { class: 'run-buttons' }, link), address, rows.length ? make('ul', { class: 'run-list' }, ...rows) : make('p', { class: 'none', text: t('runs_none') }));
  }

  // Hashes all files of a run, which takes seconds.
  async verify(name, button) {
    await this.told(button, async () => {
      const { faults, seal, signer } = await ask(`/api/runs/${encodeURIComponent(name)}/verify`);
      const whole = `${t('run_whole', { seal })}, ${signer ? t('run_signed', { signer }) : t('run_unsigned')}`;
      return faults.length ? t('run_changed', { what: faults.join('; ') }) : whole;
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
    const names = Object.keys(run.series).sort();
    const vehicles = new Map(names.map((vehicle, number) => [vehicle, { name: vehicle, facts: { number, home: null }, frame: { state: 4 } }]));
    this.run = run;
    this.map.source = { vehicles, sections: { scale: this.map.link.sections.scale, ...staticSections(run) } };
    this.map.images = {};
    for (const group of IMAGES) this.map.groups[group].clearLayers();
    this.map.isFitted = false;
    this.map.drawSections(null);
    if (!this.map.isFitted) this.fitTracks();
    if (run.tiles) this.showTiles(name, run.tiles);
    this.makeBar();
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
    for (const [name, one] of Object.entries(this.run.series)) {
      const count = upTo(one.time_s, until);
      const track = this.worlds(name, one).slice(0, count);
      this.map.tracks.set(name, track);
      for (const point of track) if (!(point[2] <= highest)) highest = point[2];
      const vehicle = this.map.source.vehicles.get(name);
      vehicle.world = track.at(-1);
      vehicle.frame.latitude = one.latitude_deg[count - 1];
      vehicle.frame.longitude = one.longitude_deg[count - 1];
    }
    this.time.textContent = `${missionClock(this.at)} · ${doseRate(highest)}`;
    this.map.trackLayer.redraw();
    this.map.schedule();
  }

  worlds(name, one) {
    this.cache ??= new Map();
    const key = `${this.run.name}/${name}`;
    if (!this.cache.has(key)) this.cache.set(key, one.latitude_deg.map((latitude, index) => [...worldOf(latitude, one.longitude_deg[index]), one.dose_rate_usvh[index]]));
    return this.cache.get(key);
  }

  stop() {
    this.isPlaying = false;
    this.bar.hidden = true;
    this.map.source = null;
    this.map.images = {};
    for (const group of IMAGES) this.map.groups[group].clearLayers();
    this.map.readTracks(this.map.link.sections.tracks ?? {});
    this.map.isFitted = false;
    this.map.drawSections(null);
    this.map.schedule();
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
