// SPDX-License-Identifier: Apache-2.0
// Quantities as text, as rocsafe_view/formats.py has them.
const DASH = '–';
const UNITS = [[1e6, 'Sv'], [1e3, 'mSv'], [1, 'µSv']];

export const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);

export function figures(value, count = 3) {
  if (!isNumber(value)) return DASH;
  if (value === 0) return '0';
  const rounded = Number(value.toPrecision(count));
  const digits = Math.max(count - 1 - Math.floor(Math.log10(Math.abs(rounded))), 0);
  return rounded.toFixed(digits).replace(/\B(?=(\d{3})+(?!\d))(?<!\.\d*)/g, '\u202f');
}

function scaled(value, end) {
  if (!isNumber(value)) return DASH;
  if (value > 0 && value < 0.001) return `< 0.001 µSv${end}`;
  const [limit, unit] = UNITS.find(([least]) => value >= least) ?? UNITS[2];
  return `${figures(value / limit, value < 1 ? 2 : 3)} ${unit}${end}`;
}

export const doseRate = (value) => scaled(value, '/h');
export const dose = (value) => scaled(value, '');

export function duration(seconds) {
  if (!isNumber(seconds)) return DASH;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${String(whole % 60).padStart(2, '0')} s`;
  const minutes = Math.round(seconds / 60);
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, '0')} min`;
}

// An age; more than an hour is told as that.
export const age = (seconds) => (!isNumber(seconds) ? DASH : seconds < 1 ? '0 s' : duration(seconds));

export const percent = (fraction) => (isNumber(fraction) ? `${fraction >= 1 ? 100 : Math.min(Math.round(fraction * 100), 99)} %` : DASH);

export function clockText(seconds) {
  const time = new Date(seconds * 1000);
  const two = (value) => String(value).padStart(2, '0');
  const local = `${two(time.getHours())}:${two(time.getMinutes())}:${two(time.getSeconds())}`;
  return [local, `${two(time.getUTCHours())}:${two(time.getUTCMinutes())}:${two(time.getUTCSeconds())} UTC`];
}

export function missionClock(seconds) {
  if (!isNumber(seconds)) return DASH;
  const whole = Math.max(Math.round(seconds), 0);
  return `${String(Math.floor(whole / 60)).padStart(2, '0')}:${String(whole % 60).padStart(2, '0')}`;
}

// An element with a class, text and children; nothing is ever made from HTML text.
export function make(tag, options = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(options)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === 'text') element.textContent = value;
    else if (name === 'class') element.className = value;
    else if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children);
  return element;
}

// The form in which places are told; the server has them all. What has no MGRS, as at the poles,
// is told in degrees.
export const PLACE_FORMS = ['decimal', 'dms', 'mgrs'];
const places = { form: PLACE_FORMS[0] };
try { if (PLACE_FORMS.includes(localStorage.rocsafePlaces)) places.form = localStorage.rocsafePlaces; } catch { /* storage refused */ }

export const placeForm = () => places.form;
export const placeText = (forms) => (forms ? forms[places.form] || forms.decimal : DASH);
export function turnPlaces() {
  places.form = PLACE_FORMS[(PLACE_FORMS.indexOf(places.form) + 1) % PLACE_FORMS.length];
  try { localStorage.rocsafePlaces = places.form; } catch { /* storage refused */ }
}
