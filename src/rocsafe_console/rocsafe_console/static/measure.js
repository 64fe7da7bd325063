// SPDX-License-Identifier: Apache-2.0
// Distances, bearings and an area on the map, between places that are chosen one after the other.
import { t } from './texts.js';
import { figures, make } from './format.js';

const L = window.L;
// WGS84: half of its long axis, metres, and the square of its eccentricity.
const AXIS_M = 6378137;
const SQUARE = 0.00669437999014;

// Metres to the north and to the east from one place to another: on the plane that touches the
// ellipsoid between them, within a ten-thousandth for some tens of kilometres.
function steps([latitude, longitude], [otherLatitude, otherLongitude]) {
  const middle = ((latitude + otherLatitude) / 2 * Math.PI) / 180;
  const across = AXIS_M / Math.sqrt(1 - SQUARE * Math.sin(middle) ** 2);
  const along = (across * (1 - SQUARE)) / (1 - SQUARE * Math.sin(middle) ** 2);
  const turn = ((otherLongitude - longitude + 540) % 360) - 180;
  return [((otherLatitude - latitude) * Math.PI * along) / 180, (turn * Math.PI * across * Math.cos(middle)) / 180];
}

export function distanceOf(from, to) { return Math.hypot(...steps(from, to)); }
export function bearingOf(from, to) {
  const [north, east] = steps(from, to);
  return ((Math.atan2(east, north) * 180) / Math.PI + 360) % 360;
}
export function areaOf(ring) {
  const points = ring.map((place) => steps(ring[0], place));
  return Math.abs(points.reduce((sum, [x, y], index) => { const [u, v] = points[(index + 1) % points.length]; return sum + x * v - u * y; }, 0)) / 2;
}

export class Ruler {
  // The box is that of a place: either is shown.
  constructor(map, box) {
    this.box = box;
    this.layer = L.layerGroup().addTo(map);
    this.places = null;
  }

  get isOn() { return this.places !== null; }

  begin(...places) { this.places = places; this.draw(); }
  add({ lat, lng }) { this.places.push([lat, lng]); this.draw(); }
  undo() { this.places.pop(); this.draw(); }
  close() { this.places = null; this.layer.clearLayers(); this.box.hidden = true; }

  get words() {
    const { places } = this;
    if (places.length < 2) return [t('measure_hint')];
    const lengths = places.slice(1).map((place, index) => distanceOf(places[index], place));
    const [before, last] = places.slice(-2);
    const words = [t('measure_leg', { length: figures(lengths.at(-1)), bearing: String(Math.round(bearingOf(before, last)) % 360).padStart(3, '0') })];
    if (places.length > 2) words.push(t('measure_all', { length: figures(lengths.reduce((sum, one) => sum + one)) }), t('measure_area', { area: figures(areaOf(places)) }));
    return words;
  }

  draw() {
    this.layer.clearLayers();
    this.layer.addLayer(L.polyline(this.places, { color: '#ffffff', weight: 5, interactive: false }));
    this.layer.addLayer(L.polyline(this.places, { color: '#10201a', weight: 2, dashArray: '6 5', interactive: false }));
    for (const place of this.places) this.layer.addLayer(L.circleMarker(place, { radius: 5, color: '#10201a', weight: 2, fillColor: '#ffffff', fillOpacity: 1, interactive: false }));
    this.box.replaceChildren(make('ul', { role: 'status' }, ...this.words.map((text) => make('li', { text }))),
      make('p', { class: 'place-row' }, make('button', { type: 'button', class: 'small', text: t('draft_undo'), onclick: () => this.undo() }), make('button', { type: 'button', class: 'small', text: t('close'), onclick: () => this.close() })));
    this.box.hidden = false;
  }
}
