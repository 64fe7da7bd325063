// SPDX-License-Identifier: Apache-2.0
// A new mission: drawn or imported, checked, planned, approved and launched.
import { t, told } from './texts.js';
import { figures, make } from './format.js';
import { ask } from './link.js';
import { jobButton } from './jobs.js';
import { areaOf } from './measure.js';
import { colourOf } from './map.js';

const L = window.L;
const LOOK_MS = 2000;
const SURE_MS = 8000;
// Of a check or a plan, as in runs/drafts.py.
const STEP_S = 120;

export class Draft {
  constructor(panel, map, link, say) {
    this.panel = panel;
    this.say = say;
    this.map = map;
    this.link = link;
    this.drawn = { region: [], exclusions: [], homes: {} };
    this.outline = { region: [], exclusions: [], vehicles: [], camera: {} };
    this.pen = null;
    this.layer = L.layerGroup();
  }

  get isDrawing() { return this.pen !== null; }

  hide() { this.close(); this.layer.remove(); }

  async show() {
    this.layer.addTo(this.map.map);
    if (this.isMade) return;
    this.isMade = true;
    const { scenarios, drafts } = await ask('/api/drafts');
    const option = (kind) => (name) => make('option', { value: `${kind}/${name}`, text: kind === 'drafts' ? `${name} *` : name });
    this.template = make('select', { id: 'draft-start', onchange: () => this.load() }, ...scenarios.map(option('scenarios')), ...drafts.map(option('drafts')));
    this.name = make('input', { id: 'draft-name', value: 'mission', maxlength: 60, pattern: '[A-Za-z0-9][A-Za-z0-9_\\-]*' });
    this.text = make('textarea', { id: 'draft-text', spellcheck: 'false', wrap: 'off', 'aria-describedby': 'draft-faults', oninput: () => { this.changed(); this.showFaults([]); }, onscroll: () => this.placeMarks() });
    this.marks = make('div', { class: 'draft-marks', 'aria-hidden': 'true' });
    this.faults = make('ul', { class: 'draft-faults', id: 'draft-faults', hidden: true });
    this.editor = make('details', {}, make('summary', { text: t('draft_text') }), make('div', { class: 'draft-editor' }, this.text, this.marks), this.faults);
    this.word = make('p', { class: 'note', role: 'status' });
    this.output = make('pre', { class: 'draft-output', tabindex: 0, role: 'status', 'aria-live': 'polite', hidden: true });
    const button = (key, action, id) => make('button', { type: 'button', class: 'small', id, text: t(key), onclick: action });
    this.fleet = make('fieldset', { class: 'draft-fleet' });
    this.camera = make('fieldset', { class: 'draft-camera' });
    this.log = make('pre', { class: 'draft-output', tabindex: 0 });
    this.state = make('b', {});
    this.end = button('mission_end', () => this.endMission(), 'mission-end');
    this.confirm = make('button', { type: 'button', class: 'small', id: 'mission-confirm', hidden: true });
    this.missionBox = make('details', { class: 'draft-mission', hidden: true }, make('summary', {}, t('mission_log')), make('p', { class: 'draft-row' }, this.state, this.end, this.confirm), this.log);
    this.file = make('input', { type: 'file', accept: '.geojson,.json,.kml,.plan,.csv', id: 'draft-file', onchange: () => this.read() });
    this.approve = make('input', { type: 'checkbox', id: 'draft-approve', disabled: true, onchange: () => { this.launch.disabled = !this.approve.checked; } });
    this.launch = make('button', { type: 'button', class: 'order order-confirm', id: 'draft-launch', disabled: true, text: t('draft_launch'), onclick: () => this.start() });
    this.panel.replaceChildren(
      make('h2', { text: t('draft_title') }),
      make('label', { for: 'draft-start', text: t('draft_start') }), this.template,
      make('label', { for: 'draft-name', text: t('draft_name') }), this.name,
      make('div', { class: 'draft-row' },
        button('draft_region', () => this.draw('region'), 'draw-region'), button('draft_exclusion', () => this.draw('exclusion'), 'draw-exclusion'),
        button('draft_undo', () => this.undo()), button('draft_done', () => this.close(), 'draw-done')),
      this.fleet,
      this.camera,
      make('label', { for: 'draft-file', text: t('draft_import') }), this.file,
      this.word,
      this.editor,
      make('div', { class: 'draft-row' },
        button('draft_save', () => this.step('save'), 'draft-check'), button('draft_plan', () => this.step('plan'), 'draft-plan'), button('draft_preflight', () => this.step('preflight')), jobButton('whatif', () => this.name.value, this.jobBox = make('div', { class: 'job-box' }))),
      this.output, this.jobBox,
      make('label', { class: 'draft-row', for: 'draft-approve' }, this.approve, make('span', { text: t('draft_approve') })),
      this.launch,
      this.missionBox);
    this.text.setAttribute('aria-label', t('draft_text'));
    await this.load();
  }

  async load() {
    const { text, outline } = await ask(`/api/drafts/${this.template.value}`);
    if (this.template.value.startsWith('drafts/')) this.name.value = this.template.value.slice(7);
    this.text.value = text;
    this.drawn = { region: [], exclusions: [], homes: {} };
    this.showFaults([]);
    this.changed();
    this.take(outline);
    const ground = [...outline.region.flat(), ...outline.vehicles.map((one) => one.home).filter(Boolean)];
    if (ground.length && !this.link.sections.mission) this.map.map.fitBounds(L.latLngBounds(ground).pad(0.1), { animate: false });
    this.look();
  }

  // What the text says: its ground under what is drawn, its vehicles and its camera to choose from.
  take(outline) {
    this.outline = outline;
    this.drawn.vehicles = undefined;
    this.drawn.camera = undefined;
    this.names = outline.vehicles.map((one) => ({ name: one.name, isChosen: true }));
    this.showFleet();
    this.camera.replaceChildren(make('legend', { text: t('draft_camera') }), ...Object.entries(outline.camera).map(([key, value]) => {
      const input = make('input', { type: 'number', id: `camera-${key}`, value, step: 'any', min: 1, onchange: () => { this.drawn.camera = { ...this.drawn.camera, [key]: Number(input.value) }; this.changed(); } });
      return make('label', { for: `camera-${key}` }, t(`draft_${key}`), input);
    }));
    this.camera.hidden = !Object.keys(outline.camera).length;
    this.paint();
  }

  showFleet() {
    const choose = () => { this.drawn.vehicles = this.names.filter((one) => one.isChosen).map((one) => one.name); this.changed(); this.paint(); };
    const rows = this.names.map((one) => {
      const box = make('input', { type: 'checkbox', id: `fly-${one.name}`, checked: one.isChosen, onchange: () => { one.isChosen = box.checked; choose(); } });
      return make('div', { class: 'draft-row' }, make('label', { class: 'draft-row', for: `fly-${one.name}` }, box, one.name), make('button', { type: 'button', class: 'small', text: `${t('draft_home')}: ${one.name}`, onclick: () => this.draw('home', one.name) }));
    });
    const add = () => {
      let number = this.names.length + 1;
      while (this.names.some((one) => one.name === `rav${number}`)) number += 1;
      this.names.push({ name: `rav${number}`, isChosen: true });
      choose();
      this.showFleet();
    };
    this.fleet.replaceChildren(make('legend', { text: t('draft_vehicles') }), ...rows, make('button', { type: 'button', class: 'small', id: 'draft-add', text: t('draft_vehicle_add'), onclick: add }));
  }

  // How the mission of this draft stands, for as long as it runs.
  async look() {
    clearTimeout(this.timer);
    const name = this.name.value;
    const mission = await ask(`/api/missions/${encodeURIComponent(name)}`).catch(() => null);
    if (!mission) return;
    this.missionBox.hidden = !mission.text;
    this.state.textContent = `${name} ${t(`mission_${mission.state}`)}`;
    if (this.log.textContent !== mission.text) this.log.textContent = mission.text;
    this.end.hidden = mission.state !== 'running' || !(this.link.sections.session?.may ?? []).includes('end');
    this.confirm.hidden = !mission.confirm;
    this.confirm.textContent = t('mission_confirm', { hash: mission.confirm });
    this.confirm.onclick = () => this.start([mission.confirm]);
    if (this.wasRunning === name && mission.state === 'failed') { this.missionBox.open = true; this.say(`${name} ${t('mission_failed')}: ${mission.text.split('\n').at(-1)}`); }
    this.wasRunning = mission.state === 'running' ? name : null;
    if (mission.state === 'running') this.timer = setTimeout(() => this.look(), LOOK_MS);
  }

  async endMission() {
    if (!this.isSure) {
      this.isSure = true;
      this.end.textContent = t('mission_end_sure');
      setTimeout(() => { this.isSure = false; this.end.textContent = t('mission_end'); }, SURE_MS);
      return;
    }
    await ask(`/api/missions/${encodeURIComponent(this.name.value)}/end`, {}).catch((error) => this.tell(error.message, false));
    this.look();
  }

  // Each mistake beside the line of its field, and in a list that leads there.
  showFaults(faults) {
    this.faultsShown = faults;
    const isAny = faults.length > 0;
    if (isAny) this.editor.open = true;
    this.text.setAttribute('aria-invalid', String(isAny));
    this.faults.hidden = !isAny;
    this.faults.replaceChildren(...faults.map((one) => {
      const where = one.line ? t('draft_fault_line', { line: one.line }) : '';
      return make('li', {}, make('button', { type: 'button', class: 'link', 'data-line': one.line, onclick: () => this.lookAt(one.line), text: [where, one.field].filter(Boolean).join(', ') || t('draft_text') }), ` ${told(one.text)}`);
    }));
    const byLine = new Map();
    for (const one of faults) if (one.line) byLine.set(one.line, [...(byLine.get(one.line) ?? []), told(one.text)]);
    this.marks.replaceChildren(...[...byLine].map(([line, texts]) => make('div', { class: 'draft-mark', 'data-line': line }, make('span', { text: `✕ ${texts.join('; ')}` }))));
    this.placeMarks();
    if (isAny) this.scrollTo(faults.find((one) => one.line)?.line ?? 0);
  }

  placeMarks() {
    const style = getComputedStyle(this.text);
    const [height, top] = [parseFloat(style.lineHeight), parseFloat(style.paddingTop)];
    for (const mark of this.marks.children) {
      const at = top + (Number(mark.dataset.line) - 1) * height - this.text.scrollTop;
      mark.style.top = `${at}px`;
      mark.style.height = `${height}px`;
      mark.hidden = at < 0 || at + height > this.text.clientHeight;
    }
  }

  scrollTo(line) {
    const height = parseFloat(getComputedStyle(this.text).lineHeight);
    this.text.scrollTop = Math.max((line - 4) * height, 0);
    this.text.scrollLeft = 0;
    this.placeMarks();
  }

  lookAt(line) {
    if (!line) return;
    const lines = this.text.value.split('\n');
    const begin = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
    this.text.focus({ preventScroll: true });
    this.text.setSelectionRange(begin, begin + (lines[line - 1]?.length ?? 0));
    this.scrollTo(line);
  }

  // A change makes what was approved void.
  changed() {
    this.approved = '';
    this.approve.checked = false;
    this.approve.disabled = true;
    this.launch.disabled = true;
    // Nor are its routes those of what is drawn.
    if (this.plan) { this.plan = null; this.paint(); }
  }

  // Whoever works by keys is led to the map: Enter there sets a corner.
  draw(kind, name) {
    this.close();
    this.pen = { kind, name, ring: [] };
    const map = this.map.map.getContainer();
    map.style.cursor = 'crosshair';
    if (document.activeElement?.matches('#draft :focus-visible')) map.focus();
  }

  onPlace({ lat, lng }) {
    const place = [Number(lat.toFixed(8)), Number(lng.toFixed(8))];
    if (this.pen.kind === 'home') { this.drawn.homes[this.pen.name] = place; this.close(); this.changed(); } else this.pen.ring.push(place);
    this.paint();
  }

  undo() {
    if (this.pen?.ring.length) this.pen.ring.pop(); else if (this.drawn.exclusions.length) this.drawn.exclusions.pop(); else this.drawn.region = [];
    this.changed();
    this.paint();
  }

  // By a key on the map: the ring is closed, and the focus goes on to what comes next.
  finish() {
    this.close();
    document.getElementById('draft-plan').focus();
  }

  close() {
    if (!this.isMade) return;
    const { kind, ring } = this.pen ?? {};
    if (ring?.length >= 3) {
      if (kind === 'region') this.drawn.region = ring; else this.drawn.exclusions.push(ring);
      this.changed();
    }
    this.pen = null;
    this.map.map.getContainer().style.cursor = '';
    this.paint();
  }

  async read() {
    const [file] = this.file.files;
    if (!file) return;
    try {
      // The first polygon is the region; its holes and all others are kept out of.
      const { areas } = await ask('/api/import', { name: file.name, text: await file.text() });
      const [[region, ...holes], ...others] = areas;
      this.drawn.region = region;
      this.drawn.exclusions.push(...holes, ...others.map(([ring]) => ring));
      this.file.value = '';
      this.changed();
      this.paint();
      if (this.drawn.region.length) this.map.map.fitBounds(L.latLngBounds(this.drawn.region).pad(0.4), { animate: false });
    } catch (error) { this.tell(error.message, false); }
  }

  paint() {
    this.layer.clearLayers();
    const { region, exclusions, homes } = this.drawn;
    const ring = this.pen?.ring ?? [];
    const before = { color: '#ffffff', weight: 2, dashArray: '4 5', fill: false, interactive: false };
    if (this.outline.region.length && !region.length) this.layer.addLayer(L.polygon(this.outline.region, before));
    if (!exclusions.length) for (const rings of this.outline.exclusions) this.layer.addLayer(L.polygon(rings, { ...before, color: '#ff8080' }));
    const flying = new Set(this.drawn.vehicles ?? this.outline.vehicles.map((one) => one.name));
    for (const { name, home } of this.outline.vehicles) if (home && !homes[name] && flying.has(name)) this.layer.addLayer(L.circleMarker(home, { radius: 6, color: '#ffffff', weight: 2, fillOpacity: 0.3, interactive: false }).bindTooltip(name, { permanent: true }));
    if (region.length) this.layer.addLayer(L.polygon(region, { color: '#ffd400', weight: 3, fillOpacity: 0.08, interactive: false }));
    for (const one of exclusions) this.layer.addLayer(L.polygon(one, { color: '#d03030', weight: 2, fillColor: '#d03030', fillOpacity: 0.3, interactive: false }));
    if (ring.length) this.layer.addLayer(L.polyline(ring, { color: '#ffd400', weight: 3, dashArray: '6 4', interactive: false }));
    // Corners can be moved.
    for (const points of [region, ...exclusions, ring]) {
      points.forEach((place, index) => {
        const icon = L.divIcon({ className: 'corner', iconSize: [16, 16] });
        const corner = L.marker(place, { icon, draggable: true, keyboard: false }).on('dragend', () => { const { lat, lng } = corner.getLatLng(); points[index] = [lat, lng]; this.changed(); this.paint(); });
        this.layer.addLayer(corner);
      });
    }
    for (const [name, place] of Object.entries(homes)) this.layer.addLayer(L.circleMarker(place, { radius: 7, color: '#ffd400', weight: 3, fillOpacity: 0.5, interactive: false }).bindTooltip(name, { permanent: true }));
    if (this.plan) {
      const names = this.outline.vehicles.map((one) => one.name);
      const style = ({ properties }) => ({ color: colourOf(Math.max(names.indexOf(properties.vehicle), 0)), weight: 3 });
      for (const under of [{ color: '#ffffff', weight: 5 }, style]) this.layer.addLayer(L.geoJSON(this.plan, { interactive: false, filter: (one) => one.geometry.type === 'LineString', style: under }));
    }
    const shown = ring.length ? ring : region;
    this.word.textContent = shown.length ? t('draft_area', { area: figures(areaOf(shown)), count: shown.length }) : '';
  }

  async step(kind) {
    if (this.isBusy) return;
    this.close();
    this.tell('', true);
    const isDone = this.count(kind);
    const name = encodeURIComponent(this.name.value);
    try {
      const saved = await ask('/api/drafts', { name: this.name.value, text: this.text.value, drawn: this.drawn });
      this.text.value = saved.scenario;
      this.take(saved.outline);
      this.showFaults(saved.faults);
      if (kind === 'save' || !saved.is_done) { this.tell(saved.text, saved.is_done); return; }
      const answer = await ask(`/api/drafts/${name}/${kind}`, {});
      this.tell(answer.text, answer.is_done);
      if (kind === 'plan' && answer.is_done) {
        this.plan = answer.plan;
        this.approved = answer.approve;
        this.approve.disabled = !(this.link.sections.session?.may ?? []).includes('launch');
        this.paint();
        const points = (answer.plan?.features ?? []).filter((one) => one.geometry.type === 'LineString').flatMap((one) => one.geometry.coordinates.map(([longitude, latitude]) => [latitude, longitude]));
        if (points.length) this.map.map.fitBounds(L.latLngBounds(points).pad(0.1), { animate: false });
      }
    } catch (error) {
      this.tell(error.message, false);
      // A text that is no YAML is refused before it is checked.
      const line = /: line (\d+): (.*)$/.exec(error.message);
      if (line) this.showFaults([{ line: Number(line[1]), field: '', text: line[2] }]);
    } finally { isDone(); }
    this.output.scrollIntoView({ block: 'nearest' });
  }

  // What is at work and for how long; returns what ends it.
  count(kind) {
    const begin = performance.now();
    const words = make('span', {});
    const tick = () => { words.textContent = t('draft_running', { step: t(`draft_${kind}`), seconds: Math.round((performance.now() - begin) / 1000), most: STEP_S }); };
    tick();
    this.output.replaceChildren(words);
    this.output.setAttribute('aria-busy', 'true');
    const timer = setInterval(tick, 1000);
    this.isBusy = true;
    return () => { clearInterval(timer); this.isBusy = false; this.output.setAttribute('aria-busy', 'false'); };
  }

  async start(confirm = []) {
    this.launch.disabled = true;
    this.tell(t('draft_launching'), true);
    try {
      const answer = await ask(`/api/drafts/${encodeURIComponent(this.name.value)}/launch`, { approved: this.approved, confirm });
      const isGood = answer.state !== 'failed';
      this.tell(answer.text, isGood);
      this.look();
      if (isGood) {
        const live = document.querySelector('button[data-view="live"]');
        live.click();
        live.focus();
      }
    } catch (error) { this.tell(error.message, false); }
  }

  tell(text, isGood) {
    this.output.hidden = false;
    this.output.textContent = `${isGood ? '' : '✕ '}${text}`;
    this.output.classList.toggle('warn', !isGood);
  }
}
