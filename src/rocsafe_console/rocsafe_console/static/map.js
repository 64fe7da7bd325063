// SPDX-License-Identifier: Apache-2.0
// The map: Leaflet without its icons; vehicles and tracks on canvases of their own.
import { t } from './texts.js';
import { make, isNumber } from './format.js';
import { STALE_S } from './link.js';

const L = window.L;
export const VEHICLE_COLOURS = ['#0a7bbf', '#d55e00', '#80aa80', '#5600ff', '#56562b', '#ff56ff', '#aa5680', '#802bd5'];
export const colourOf = (rank) => VEHICLE_COLOURS[(rank ?? 0) % VEHICLE_COLOURS.length];
const GREY = '#8b938f';
const M_PER_DEG = 111320;
const MOST_LABELS = 40;
// Of vehicles and their names: a wall is looked at from afar.
const SIZE = matchMedia('(min-width: 2200px)').matches ? 1.5 : 1;
// Lines of who hears whom; of more vehicles only those of the chosen ones are drawn.
const MOST_IN_CONTACT = 12;
const MOST_TRACK = 4000;
// Numbers of VehicleState.
const [HOLDING, RETURNING, LANDING, LOST, CRASHED] = [5, 6, 7, 9, 10];
const ON_GROUND = new Set([1, 2, 8, 11]);
const LAYERS = {
  base: true, mosaic: true, dose: true, footprints: false, tracks: true, routes: true, region: true, exclusions: true,
  drive: true, cordons: true, plume: true, zones: true, sources: true, homes: true, marks: true, contact: true, grid: true,
};

// A canvas over the map that is drawn by `draw(context, toPixel)` with points in world units.
const CanvasLayer = L.Layer.extend({
  initialize(draw, options) { this.drawing = draw; L.setOptions(this, options); },
  onAdd(map) {
    this.canvas = L.DomUtil.create('canvas', 'over-map', map.getPane(this.options.pane ?? 'overlayPane'));
    this.canvas.setAttribute('aria-hidden', 'true');
    map.on('moveend zoomend resize viewreset', this.redraw, this);
    this.redraw();
  },
  onRemove(map) { map.off('moveend zoomend resize viewreset', this.redraw, this); this.canvas.remove(); },
  redraw() {
    const map = this._map;
    if (!map) return;
    const size = map.getSize();
    const pad = size.multiplyBy(0.15).round();
    const whole = size.add(pad.multiplyBy(2));
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (this.canvas.width !== Math.round(whole.x * ratio) || this.canvas.height !== Math.round(whole.y * ratio)) {
      this.canvas.width = Math.round(whole.x * ratio);
      this.canvas.height = Math.round(whole.y * ratio);
      this.canvas.style.width = `${whole.x}px`;
      this.canvas.style.height = `${whole.y}px`;
    }
    L.DomUtil.setPosition(this.canvas, map.containerPointToLayerPoint(pad.multiplyBy(-1)));
    const context = this.canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, whole.x, whole.y);
    const scale = map.options.crs.scale(map.getZoom());
    const origin = map.getPixelBounds().min.subtract(pad);
    this.toPixel = (world) => [world[0] * scale - origin.x, world[1] * scale - origin.y];
    this.drawing(context, this.toPixel, whole, false);
  },
  // Draws on what is there: for what has only grown.
  extend() { if (this.toPixel && this._map) this.drawing(this.canvas.getContext('2d'), this.toPixel, null, true); },
});

// Web Mercator with the world from 0 to 1, so that a zoom is one multiplication.
export function worldOf(latitude, longitude) {
  const sine = Math.sin((Math.min(Math.max(latitude, -85), 85) * Math.PI) / 180);
  return [longitude / 360 + 0.5, 0.5 - Math.log((1 + sine) / (1 - sine)) / (4 * Math.PI)];
}

export class MissionMap {
  constructor(element, link) {
    this.link = link;
    this.selected = new Set();
    this.shown = { ...LAYERS };
    try { Object.assign(this.shown, JSON.parse(localStorage.rocsafeLayers ?? '{}')); } catch { /* storage refused */ }
    this.map = L.map(element, {
      preferCanvas: true, zoomAnimation: false, fadeAnimation: false, markerZoomAnimation: false,
      attributionControl: false, zoomControl: false, minZoom: 2, maxZoom: 24, zoomSnap: 0.25, inertia: false,
    }).setView([20, 0], 3);
    L.control.zoom({ position: 'topleft', zoomInTitle: t('zoom_in'), zoomOutTitle: t('zoom_out') }).addTo(this.map);
    L.control.scale({ position: 'bottomleft', imperial: false }).addTo(this.map);
    this.map.createPane('base').style.zIndex = 210;
    this.map.createPane('images').style.zIndex = 250;
    this.map.createPane('tracks').style.zIndex = 420;
    this.map.createPane('vehicles').style.zIndex = 640;
    this.groups = Object.fromEntries(Object.keys(LAYERS).map((name) => [name, L.layerGroup()]));
    this.images = {};
    this.liveTracks = new Map();
    this.stops = [];
    this.isFitted = false;
    this.groups.grid.addLayer(new CanvasLayer((...all) => this.drawGrid(...all), { pane: 'images' }));
    this.trackLayer = new CanvasLayer((...all) => this.drawTracks(...all), { pane: 'tracks' });
    this.groups.tracks.addLayer(this.trackLayer);
    this.homeLayer = new CanvasLayer((...all) => this.drawHomes(...all), { pane: 'tracks' });
    this.groups.homes.addLayer(this.homeLayer);
    this.vehicleLayer = new CanvasLayer((...all) => this.drawVehicles(...all), { pane: 'vehicles' }).addTo(this.map);
    for (const [name, group] of Object.entries(this.groups)) if (this.shown[name]) group.addTo(this.map);
    new ResizeObserver(() => this.map.invalidateSize({ animate: false })).observe(element);
    this.map.on('click', (event) => this.onClick(event));
    this.map.on('zoomend', () => this.declutter());
    link.addEventListener('sections', (event) => this.onSections(event.detail));
    link.addEventListener('frame', () => this.onFrame());
    this.source = null;
  }

  drawBase() {
    const base = this.link.sections.base_map;
    this.groups.base.clearLayers();
    if (!base) return;
    this.groups.base.addLayer(L.tileLayer('/api/base/{z}/{x}/{y}', {
      pane: 'base', minZoom: base.zooms[0], maxZoom: 24, maxNativeZoom: base.zooms[1], bounds: base.bounds ? [base.bounds.slice(0, 2), base.bounds.slice(2)] : undefined,
    }));
    this.attribution ??= L.control.attribution({ prefix: false, position: 'bottomleft' }).addTo(this.map);
    if (base.attribution && this.credit !== base.attribution) this.attribution.addAttribution(this.credit = base.attribution.replace(/[<>&]/g, ' '));
  }

  drawLegend() {
    const box = document.getElementById('legend');
    const scales = [['legend', this.stops]];
    if (this.sections.plume) scales.push(['legend_gas', this.sections.gas_scale ?? this.link.sections.gas_scale ?? []]);
    box.setAttribute('aria-label', scales.map(([name, stops]) => `${t(name)}: ${stops.map(([value]) => value).join(', ')}`).join('; '));
    box.replaceChildren(...scales.flatMap(([name, stops]) => {
      const bar = make('div', { class: 'legend-bar' }, ...stops.map(([, colour]) => { const part = make('span'); part.style.background = colour; return part; }));
      const ticks = make('div', { class: 'legend-ticks' }, ...stops.map(([value]) => make('span', { text: value >= 1000 ? `${value / 1000}k` : `${value}` })));
      return [make('b', { text: t(name) }), bar, ticks];
    }));
  }

  // What is shown is live, or a replay with sections and vehicles of its own.
  get sections() { return this.source?.sections ?? this.link.sections; }
  get vehicles() { return this.source?.vehicles ?? this.link.vehicles; }
  get tracks() { return this.source?.tracks ?? this.liveTracks; }
  isOld(vehicle) { return this.source ? false : this.link.isPlaceOld(vehicle); }

  switches() {
    return Object.keys(LAYERS).map((name) => {
      const box = make('input', { type: 'checkbox', id: `layer-${name}`, onchange: () => this.show(name, box.checked) });
      box.checked = this.shown[name];
      return make('label', { class: 'switch', for: `layer-${name}` }, box, make('span', { text: t(`layer_${name}`) }));
    });
  }

  show(name, isShown) {
    this.shown[name] = isShown;
    if (isShown) this.groups[name].addTo(this.map); else this.groups[name].remove();
    try { localStorage.rocsafeLayers = JSON.stringify(this.shown); } catch { /* storage refused */ }
  }

  onSections({ names, isHello }) {
    if (this.source) return;
    if (isHello) this.readTracks(this.link.sections.tracks ?? {});
    if (isHello) this.images = {};
    // The map moves by itself for another mission only: not under the hand of somebody.
    const mission = this.link.sections.mission?.id;
    if (mission !== this.mission) { this.mission = mission; this.isFitted = false; }
    this.drawSections(isHello ? null : new Set(names));
  }

  drawSections(names) {
    const has = (...all) => !names || all.some((name) => names.has(name));
    const sections = this.sections;
    this.stops = sections.scale ?? this.link.sections.scale ?? this.stops;
    if (has('scale')) this.drawLegend();
    if (!names) this.drawBase();
    if (has('region', 'plan')) this.drawPlan(sections);
    if (has('drive')) this.drawDrive(sections.drive);
    if (has('cordons')) this.drawCordons(sections.cordons ?? []);
    if (has('zones')) this.drawZones(sections.zones ?? []);
    if (has('sources', 'releases')) this.drawSources(sections);
    if (has('marks')) this.drawMarks(sections.marks ?? []);
    if (has('mosaic')) this.drawImage('mosaic', sections.mosaic, 1);
    if (has('dose_map')) this.drawImage('dose', sections.dose_map, 1, 'dose_map');
    if (has('plume')) { this.drawImage('plume', sections.plume, 1); this.drawLegend(); }
    if (!names || [...names].some((name) => name.startsWith('vehicle/') || name === 'tracks')) this.showHomes();
    if (!this.isFitted && (sections.region || sections.plan)) this.fit(false);
    this.declutter();
  }

  // A label over another one can be read by nobody: those of sources stay, then the first one.
  declutter() {
    if (this.isCluttered) return;
    this.isCluttered = true;
    requestAnimationFrame(() => {
      this.isCluttered = false;
      const kept = [];
      const labels = [...this.map.getPane('markerPane').querySelectorAll('.map-label')];
      const boxes = labels.map((one) => [one, one.getBoundingClientRect()]);
      boxes.sort(([a], [b]) => Number(b.classList.contains('map-label-source')) - Number(a.classList.contains('map-label-source')));
      for (const [one, box] of boxes) {
        const isFree = kept.every((other) => box.right < other.left || other.right < box.left || box.bottom < other.top || other.bottom < box.top);
        one.classList.toggle('is-over', !isFree);
        if (isFree) kept.push(box);
      }
    });
  }

  // First the ground that is surveyed, as the report does; `f` shows all.
  fit(isAll = true) {
    const ground = (this.sections.region?.rings ?? []).flat();
    if (!isAll && ground.length) { this.map.fitBounds(L.latLngBounds(ground).pad(0.35), { animate: false }); this.isFitted = true; return; }
    const points = [...(this.sections.region?.rings ?? []).flat(), ...Object.values(this.sections.plan?.routes ?? {}).flatMap((route) => route.line)];
    for (const vehicle of this.vehicles.values()) if (isNumber(vehicle.frame?.latitude)) points.push([vehicle.frame.latitude, vehicle.frame.longitude]);
    if (points.length) { this.map.fitBounds(L.latLngBounds(points).pad(0.06), { animate: false }); this.isFitted = true; }
  }

  drawPlan({ region, plan }) {
    for (const name of ['region', 'routes', 'exclusions', 'footprints']) this.groups[name].clearLayers();
    if (region) {
      this.groups.region.addLayer(L.polygon(region.rings, { color: '#0b100e', weight: 5, opacity: 0.6, fill: false, interactive: false }));
      this.groups.region.addLayer(L.polygon(region.rings, { color: '#ffffff', weight: 2, fill: false, interactive: false }));
    }
    for (const rings of plan?.exclusions ?? []) this.groups.exclusions.addLayer(L.polygon(rings, { color: '#d03030', weight: 2, fillColor: '#d03030', fillOpacity: 0.25, interactive: false }));
    Object.entries(plan?.routes ?? {}).forEach(([name, route], index) => {
      const colour = colourOf(this.vehicles.get(name)?.rank ?? index);
      this.groups.routes.addLayer(L.polyline(route.line, { color: '#0b100e', weight: 4, opacity: 0.5, interactive: false }));
      this.groups.routes.addLayer(L.polyline(route.line, { color: '#ffffff', weight: 1.6, dashArray: '6 5', opacity: 0.9, interactive: false }));
      if (plan.footprint_m) for (const viewpoint of route.viewpoints) this.groups.footprints.addLayer(L.polygon(footprint(viewpoint, plan.footprint_m), { color: colour, weight: 1, fillOpacity: 0.12, interactive: false }));
    });
  }

  // The drive that is offered, else the newest of the mission; what is driven is its vehicle's track.
  offerDrive(drive) { this.offered = drive; this.drawDrive(this.sections.drive); }

  drawDrive(planned) {
    this.groups.drive.clearLayers();
    const drive = this.offered ?? planned;
    if (!drive?.line.length) return;
    const dash = this.offered ? '3 6' : '10 5';
    this.groups.drive.addLayer(L.polyline(drive.line, { color: '#0b100e', weight: 6, opacity: 0.6, interactive: false }));
    this.groups.drive.addLayer(L.polyline(drive.line, { color: '#ffb14e', weight: 3, dashArray: dash, interactive: false }));
    for (const stand of drive.stands) {
      this.groups.drive.addLayer(L.circleMarker(stand.place, { radius: 5, color: '#0b100e', weight: 2, fillColor: '#ffb14e', fillOpacity: 1, interactive: false }));
      this.groups.drive.addLayer(label(stand.place, stand.id, 'map-label'));
    }
  }

  drawCordons(cordons) {
    this.groups.cordons.clearLayers();
    const sorted = [...cordons].sort((a, b) => a.level_usvh - b.level_usvh);
    for (const cordon of sorted) {
      this.groups.cordons.addLayer(L.polyline(cordon.ring, { color: '#0b100e', weight: 4, opacity: 0.55, interactive: false }));
      const line = L.polyline(cordon.ring, { color: '#ff5c5c', weight: cordon.is_mean ? 2.4 : 1.6, dashArray: cordon.is_mean ? null : '7 5', interactive: false });
      this.groups.cordons.addLayer(line);
      if (!cordon.is_mean && cordon.ring.length) {
        const top = cordon.ring.reduce((a, b) => (b[0] > a[0] ? b : a));
        this.groups.cordons.addLayer(label(top, `${cordon.level_usvh} µSv/h`, 'map-label'));
      }
    }
  }

  drawZones(zones) {
    this.groups.zones.clearLayers();
    for (const zone of zones) {
      this.groups.zones.addLayer(L.polyline(zone.ring, { color: '#0b100e', weight: 5, opacity: 0.55, interactive: false }));
      this.groups.zones.addLayer(L.polyline(zone.ring, { color: zone.colour, weight: zone.is_mean ? 3 : 2, dashArray: zone.is_mean ? null : '2 6', interactive: false }));
      if (!zone.is_mean && zone.ring.length) this.groups.zones.addLayer(label(zone.ring.reduce((a, b) => (b[1] > a[1] ? b : a)), zone.level, 'map-label'));
    }
  }

  drawSources({ sources, releases }) {
    this.groups.sources.clearLayers();
    for (const release of releases?.releases ?? []) {
      const ring = ellipse(release.place, [release.radius_95_m, release.radius_95_m], 0);
      this.groups.sources.addLayer(L.polygon(ring, { color: '#63d4c0', weight: 2, fillOpacity: 0.14, interactive: false }));
      this.groups.sources.addLayer(L.circleMarker(release.place, { radius: 7, color: '#14130a', weight: 1.5, fillColor: '#63d4c0', fillOpacity: 1, interactive: false }));
      this.groups.sources.addLayer(label(release.place, t('release_name', { id: release.id }), 'map-label map-label-source'));
    }
    for (const source of sources?.sources ?? []) {
      const ring = ellipse(source.place, source.half_axes_m, source.angle_deg);
      this.groups.sources.addLayer(L.polygon(ring, { color: '#00e5ff', weight: 2, fillOpacity: 0.14, interactive: false }));
      this.groups.sources.addLayer(L.circleMarker(source.place, { radius: 7, color: '#14130a', weight: 1.5, fillColor: '#ffd400', fillOpacity: 1, interactive: false }));
      this.groups.sources.addLayer(label(source.place, t('source_name', { id: source.id }), 'map-label map-label-source'));
    }
  }

  drawMarks(marks) {
    this.groups.marks.clearLayers();
    for (const mark of marks) {
      const place = [mark.latitude_deg, mark.longitude_deg];
      this.groups.marks.addLayer(L.circleMarker(place, { radius: 6, color: '#0b100e', weight: 2, fillColor: '#ffffff', fillOpacity: 1, interactive: false }));
      this.groups.marks.addLayer(label(place, mark.text, 'map-label'));
    }
  }

  showHomes() {
    const key = [...this.vehicles.values()].map((vehicle) => vehicle.facts?.home).join('|');
    if (this.homes === key) return;
    this.homes = key;
    this.homeLayer.redraw();
  }

  drawHomes(context, toPixel) {
    context.lineWidth = 3;
    context.fillStyle = 'rgb(255 255 255 / 90%)';
    for (const vehicle of this.vehicles.values()) {
      const home = vehicle.facts?.home;
      if (!home) continue;
      context.strokeStyle = this.colourOf(vehicle);
      context.beginPath();
      context.arc(...toPixel(worldOf(home[0], home[1])), 6, 0, 7);
      context.fill();
      context.stroke();
    }
  }

  drawImage(name, value, opacity, image = name) {
    if (!value?.corners || value.corners.flat().some((part) => !isNumber(part))) {
      if (this.images[name]) { this.groups[name].removeLayer(this.images[name]); delete this.images[name]; }
      return;
    }
    const url = value.url ?? `/api/image/${image}?at=${encodeURIComponent(`${value.stamp_s}-${value.heard_s}`)}`;
    const old = this.images[name];
    const picture = L.imageOverlay(url, value.corners, { pane: 'images', opacity, className: `image-${name}`, interactive: false, alt: '' });
    this.images[name] = picture;
    picture.on('load error', () => old && this.groups[name].removeLayer(old));
    this.groups[name].addLayer(picture);
  }

  readTracks(tracks) {
    this.liveTracks.clear();
    for (const [name, points] of Object.entries(tracks)) this.liveTracks.set(name, points.map(([lat, lon, rate]) => [...worldOf(lat, lon), rate ?? NaN]));
    this.trackLayer.redraw();
  }

  onFrame() {
    let hasNew = false;
    for (const vehicle of this.link.vehicles.values()) {
      const frame = vehicle.frame;
      if (!frame || !isNumber(frame.latitude)) continue;
      vehicle.world = worldOf(frame.latitude, frame.longitude);
      const track = this.liveTracks.get(vehicle.name) ?? [];
      const last = track.at(-1);
      if (!last || Math.hypot(vehicle.world[0] - last[0], vehicle.world[1] - last[1]) > 4e-8) {
        track.push([...vehicle.world, frame.doseRate]);
        if (track.length > MOST_TRACK) { track.splice(0, MOST_TRACK / 4); this.drawn?.delete(vehicle.name); }
        this.liveTracks.set(vehicle.name, track);
        hasNew = true;
      }
    }
    // A replay goes on beside the mission, whose tracks grow unseen.
    if (this.source) return;
    this.isTrackNew ||= hasNew;
    this.schedule();
  }

  // One drawing a frame of the screen, however many messages came; tracks once a second.
  schedule() {
    if (this.isScheduled) return;
    this.isScheduled = true;
    requestAnimationFrame((time) => {
      this.isScheduled = false;
      this.vehicleLayer.redraw();
      if (this.isTrackNew && time - (this.trackDrawn ?? 0) > 1000) {
        this.trackDrawn = time;
        this.isTrackNew = false;
        this.trackLayer.extend();
      }
    });
  }

  colourOf(vehicle) { return colourOf(vehicle.rank); }

  doseColour(rate) {
    if (!isNumber(rate) || !this.stops.length) return null;
    const stop = [...this.stops].reverse().find(([least]) => rate >= least);
    return stop ? stop[1] : this.stops[0][1];
  }

  drawGrid(context, toPixel, size) {
    const metres = 40075016 * Math.cos((this.map.getCenter().lat * Math.PI) / 180) / this.map.options.crs.scale(this.map.getZoom());
    const power = 10 ** Math.ceil(Math.log10(metres * 60));
    const step = power / metres;
    const [x0, y0] = toPixel([0.5, 0.5]);
    context.strokeStyle = 'rgb(255 255 255 / 9%)';
    context.lineWidth = 1;
    context.beginPath();
    for (let x = ((x0 % step) + step) % step; x < size.x; x += step) { context.moveTo(x, 0); context.lineTo(x, size.y); }
    for (let y = ((y0 % step) + step) % step; y < size.y; y += step) { context.moveTo(0, y); context.lineTo(size.x, y); }
    context.stroke();
  }

  drawTracks(context, toPixel, _size, isMore) {
    this.drawn ??= new Map();
    if (!isMore) this.drawn.clear();
    context.lineJoin = 'round';
    context.lineCap = 'round';
    for (const [name, track] of this.tracks) {
      const from = Math.max((this.drawn.get(name) ?? 1) - 1, 0);
      this.drawn.set(name, track.length);
      if (track.length - from < 2) continue;
      const pixels = track.slice(from).map(toPixel);
      context.strokeStyle = 'rgb(11 16 14 / 55%)';
      context.lineWidth = 7;
      context.beginPath();
      pixels.forEach(([x, y], index) => (index ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.stroke();
      context.lineWidth = 4;
      let colour = null;
      pixels.forEach(([x, y], index) => {
        const next = this.doseColour(track[from + index][2]) ?? '#dfe6e2';
        if (next !== colour) {
          if (colour) { context.lineTo(x, y); context.stroke(); }
          context.beginPath();
          context.moveTo(x, y);
          context.strokeStyle = next;
          colour = next;
        } else context.lineTo(x, y);
      });
      if (colour) context.stroke();
    }
  }

  // Who hears whom, as the agents tell: solid both ways, dashed one way, nothing that is old.
  drawContact(context, toPixel) {
    const contacts = this.sections.contacts ?? {};
    const isFresh = (name) => isNumber(contacts[name]?.heard_s) && this.link.now - contacts[name].heard_s <= STALE_S && this.link.isLive;
    const hears = (a, b) => isFresh(a) && contacts[a].hears.includes(b);
    const names = Object.keys(contacts).filter((name) => this.vehicles.get(name)?.world);
    const isFew = names.length <= MOST_IN_CONTACT;
    for (const [index, a] of names.entries()) {
      for (const b of names.slice(index + 1)) {
        const [there, back] = [hears(a, b), hears(b, a)];
        if (!(there || back) || !(isFew || this.selected.has(a) || this.selected.has(b))) continue;
        context.beginPath();
        context.moveTo(...toPixel(this.vehicles.get(a).world));
        context.lineTo(...toPixel(this.vehicles.get(b).world));
        context.setLineDash(there && back ? [] : [3, 6]);
        for (const [width, colour] of [[4, 'rgb(11 16 14 / 45%)'], [1.6, '#9fe8ff']]) { context.lineWidth = width; context.strokeStyle = colour; context.stroke(); }
      }
    }
    context.setLineDash([]);
  }

  drawVehicles(context, toPixel) {
    if (this.shown.contact && !this.source) this.drawContact(context, toPixel);
    const isLabelled = this.vehicles.size <= MOST_LABELS;
    context.font = `650 ${12 * SIZE}px system-ui, "Liberation Sans", sans-serif`;
    context.textBaseline = 'middle';
    for (const vehicle of this.vehicles.values()) {
      if (!vehicle.world) continue;
      const [x, y] = toPixel(vehicle.world);
      const isStale = this.isOld(vehicle);
      const isChosen = this.selected.has(vehicle.name);
      drawVehicle(context, x, y, vehicle.frame.state, isStale ? GREY : this.colourOf(vehicle), isStale, vehicle.facts?.is_ground);
      if (isChosen) { context.strokeStyle = '#ffd400'; context.lineWidth = 3; context.beginPath(); context.arc(x, y, 15 * SIZE, 0, 7); context.stroke(); }
      if (isLabelled || isChosen) {
        context.lineWidth = 3.5 * SIZE;
        context.strokeStyle = 'rgb(11 16 14 / 90%)';
        context.fillStyle = isStale ? '#c9cfcc' : '#ffffff';
        const text = isStale ? `${vehicle.name} (${t('stale')})` : vehicle.name;
        context.strokeText(text, x + 13 * SIZE, y);
        context.fillText(text, x + 13 * SIZE, y);
      }
    }
  }

  onClick(event) {
    const near = this.vehicleAt(event.containerPoint);
    if (near) this.onVehicle?.(near, event.originalEvent);
    else this.onPlace?.(event.latlng);
  }

  // By keys, what a click does at the middle of the map.
  chooseMiddle() { this.onClick({ containerPoint: this.map.getSize().divideBy(2), latlng: this.map.getCenter() }); }

  vehicleAt(point) {
    const scale = this.map.options.crs.scale(this.map.getZoom());
    const origin = this.map.getPixelBounds().min;
    let best = null;
    let least = 18;
    for (const vehicle of this.vehicles.values()) {
      if (!vehicle.world) continue;
      const distance = Math.hypot(vehicle.world[0] * scale - origin.x - point.x, vehicle.world[1] * scale - origin.y - point.y);
      if (distance < least) { least = distance; best = vehicle.name; }
    }
    return best;
  }
}

// The state is told by the shape as well: no colour alone means anything.
function drawVehicle(context, x, y, state, colour, isStale, isGround) {
  context.save();
  context.translate(x * (1 - SIZE), y * (1 - SIZE));
  context.scale(SIZE, SIZE);
  if (isGround) {
    // Tracks at both sides: it drives.
    context.lineWidth = 5;
    context.strokeStyle = '#0b100e';
    context.beginPath();
    for (const side of [-12, 12]) { context.moveTo(x - 9, y + side); context.lineTo(x + 9, y + side); }
    context.stroke();
  }
  context.lineWidth = 2.5;
  context.strokeStyle = isStale ? '#e4e8e6' : '#ffffff';
  context.fillStyle = colour;
  context.beginPath();
  if (state === HOLDING) context.rect(x - 7, y - 7, 14, 14);
  else if (state === RETURNING || state === LANDING) { context.moveTo(x, y + 9); context.lineTo(x - 8, y - 6); context.lineTo(x + 8, y - 6); context.closePath(); }
  else if (state === LOST || state === CRASHED) { context.moveTo(x - 8, y - 8); context.lineTo(x + 8, y + 8); context.moveTo(x + 8, y - 8); context.lineTo(x - 8, y + 8); context.strokeStyle = isStale ? GREY : '#ff5c5c'; context.lineWidth = 4.5; }
  else context.arc(x, y, ON_GROUND.has(state) ? 5 : 7.5, 0, 7);
  if (isStale) context.setLineDash([3, 3]); else context.fill();
  context.stroke();
  context.restore();
}

function label(place, text, className) {
  const icon = L.divIcon({ className: 'label-anchor', html: make('span', { class: className, text }), iconSize: [0, 0] });
  return L.marker(place, { icon, interactive: false, keyboard: false });
}

function footprint([latitude, longitude, yaw], [across, along]) {
  const [ahead, side] = [along / 2, across / 2];
  return [[ahead, side], [ahead, -side], [-ahead, -side], [-ahead, side]].map(([forward, left]) => {
    const east = forward * Math.cos(yaw) - left * Math.sin(yaw);
    const north = forward * Math.sin(yaw) + left * Math.cos(yaw);
    return offset(latitude, longitude, east, north);
  });
}

export function offset(latitude, longitude, east, north) {
  return [latitude + north / M_PER_DEG, longitude + east / (M_PER_DEG * Math.cos((latitude * Math.PI) / 180))];
}

function ellipse([latitude, longitude], [a, b], degrees) {
  const turn = (degrees * Math.PI) / 180;
  return Array.from({ length: 48 }, (_, index) => {
    const angle = (index * Math.PI) / 24;
    const [u, v] = [a * Math.cos(angle), b * Math.sin(angle)];
    return offset(latitude, longitude, u * Math.cos(turn) - v * Math.sin(turn), u * Math.sin(turn) + v * Math.cos(turn));
  });
}
