// SPDX-License-Identifier: Apache-2.0
// The page: log-in, views, keys, theme, alarms, and the word whether it is live.
import { addTexts, fillTexts, t, told } from './texts.js';
import { age, clockText, isNumber, make, missionClock, placeForm, turnPlaces } from './format.js';
import { Link, ask, tellBy } from './link.js';
import { MissionMap } from './map.js';
import { Facts, isOver, reportLink } from './facts.js';
import { Orders } from './orders.js';
import { Video } from './video.js';
import { Sound } from './sound.js';
import { Runs } from './runs.js';
import { Draft } from './draft.js';
import { Ruler } from './measure.js';

const REVOKED = 4401;
const MISSION_SILENT_S = 3;
const $ = (selector) => document.querySelector(selector);
const root = document.documentElement;

// Theme: the system's until somebody chooses.
const systemDark = matchMedia('(prefers-color-scheme: dark)');
const isDark = () => (root.dataset.theme || (systemDark.matches ? 'dark' : 'light')) === 'dark';
const nameTheme = () => { $('#theme').textContent = t(isDark() ? 'theme_light' : 'theme_dark'); };
function turnTheme() {
  root.dataset.theme = isDark() ? 'light' : 'dark';
  try { localStorage.rocsafeTheme = root.dataset.theme; } catch { /* storage refused */ }
  nameTheme();
}
try { if (localStorage.rocsafeTheme) root.dataset.theme = localStorage.rocsafeTheme; } catch { /* storage refused */ }

fillTexts();
tellBy(told);
// Not needed before the first facts, nor in English.
import('./mission_texts.js').then(({ MISSION_TEXTS }) => addTexts(MISSION_TEXTS));
nameTheme();
const link = new Link();
const map = new MissionMap($('#map'), link);
const selection = map.selected;
const orders = new Orders($('#orders'), link, selection);
const facts = new Facts($('#facts'), link, {
  look: (latitude, longitude) => map.map.setView([latitude, longitude], Math.max(map.map.getZoom(), 19), { animate: false }),
  acknowledge: (number) => ask(`/api/alarms/${number}/acknowledge`, {}).catch((error) => orders.tell([], t('refused', { why: error.message }))),
  select, isSelected: (name) => selection.has(name),
});
const video = new Video(facts.boxes.camera, link);
const runs = new Runs($('#runs'), $('#replay'), map);
runs.onChange = () => orders.draw();
const draft = new Draft($('#draft'), map, link, (text) => orders.tell([], text));
const ruler = new Ruler(map.map, $('#place'));
window.rocsafe = { link, map, orders, facts, video, draft, ruler };

function select(name, isChosen) {
  if (isChosen) selection.add(name); else selection.delete(name);
  orders.draw();
  map.schedule();
  facts.draw();
}
orders.onOffer = (drive) => map.offerDrive(drive);
map.onVehicle = (name) => select(name, !selection.has(name));
map.onPlace = (place) => (ruler.isOn ? ruler.add(place) : draft.isDrawing ? draft.onPlace(place) : showPlace(place));

// A place: its coordinates in all forms, a mark, and go to for one chosen vehicle.
async function showPlace({ lat, lng }) {
  const box = $('#place');
  const forms = await ask(`/api/coordinates?latitude=${lat}&longitude=${lng}`).catch(() => null);
  if (!forms) { box.hidden = true; return; }
  const rows = Object.values(forms).filter(Boolean).map((text) => make('li', {}, make('code', { text }), make('button', { type: 'button', class: 'small', text: t('copy'), onclick: () => navigator.clipboard?.writeText(text) })));
  const parts = [make('ul', {}, ...rows)];
  const may = link.sections.session?.may ?? [];
  const chosen = [...selection];
  if (may.includes('go_to') && chosen.length === 1 && !link.vehicles.get(chosen[0])?.facts.is_ground) {
    const height = make('input', { type: 'number', min: 5, max: 500, value: 50 });
    parts.push(make('p', { class: 'place-row' }, make('label', { class: 'note' }, `${t('place_height')} `, height), make('button', { type: 'button', class: 'small', text: t('place_go_to', { vehicle: chosen[0] }), onclick: () => { orders.arm('go_to', chosen, { latitude_deg: lat, longitude_deg: lng, height_m: Number(height.value) }); box.hidden = true; } })));
  }
  if (may.includes('send')) {
    const budget = make('input', { type: 'number', min: 1, max: 1e6, value: 100 });
    const drivers = [...link.vehicles.values()].filter((vehicle) => vehicle.facts.is_ground).map((vehicle) => make('button', { type: 'button', class: 'small', 'data-send': vehicle.name, text: t('place_send', { vehicle: vehicle.name }), onclick: () => { orders.arm('send', [vehicle.name], { latitude_deg: lat, longitude_deg: lng, dose_budget_usv: Number(budget.value) }); box.hidden = true; } }));
    if (drivers.length) parts.push(make('p', { class: 'place-row' }, make('label', { class: 'note' }, `${t('place_dose')} `, budget), ...drivers));
  }
  if (may.includes('mark')) {
    const text = make('input', { type: 'text', maxlength: 500, placeholder: t('mark_text'), 'aria-label': t('mark_text') });
    const save = async (event) => {
      event.preventDefault();
      await ask('/api/marks', { latitude_deg: lat, longitude_deg: lng, text: text.value }).then(() => { box.hidden = true; }, (error) => orders.tell([], t('refused', { why: error.message })));
    };
    parts.push(make('form', { class: 'place-row', onsubmit: save }, text, make('button', { class: 'small', text: t('mark_save') })));
  }
  parts.push(make('p', { class: 'place-row' }, make('button', { type: 'button', class: 'small', id: 'measure', text: t('measure'), onclick: () => ruler.begin([lat, lng]) }), make('button', { type: 'button', class: 'small', text: t('close'), onclick: () => { box.hidden = true; } })));
  box.replaceChildren(...parts);
  box.hidden = false;
  if (document.activeElement === $('#map')) box.querySelector('button, input').focus();
}

// Views.
function show(view) {
  for (const button of document.querySelectorAll('button[data-view]')) button.setAttribute('aria-pressed', String(button.dataset.view === view));
  $('#facts').hidden = view !== 'live';
  $('#runs').hidden = view !== 'runs';
  $('#draft').hidden = view !== 'draft';
  root.dataset.view = view;
  video.turn();
  if (view === 'runs') runs.show().catch((error) => orders.tell([], error.message));
  if (view !== 'draft') draft.hide();
  if (view === 'draft') draft.show().catch((error) => orders.tell([], error.message));
  if (view === 'live' && map.source) runs.stop();
  $('#panel').scrollTop = 0;
}
for (const button of document.querySelectorAll('button[data-view]')) button.addEventListener('click', () => show(button.dataset.view));

// Places in degrees, in degrees with minutes and seconds, or in MGRS.
const namePlaces = () => { $('#places').textContent = t(`places_${placeForm()}`); };
$('#places').addEventListener('click', () => { turnPlaces(); namePlaces(); facts.draw(); });
namePlaces();

// Alarms are heard as well as seen.
// The click that wakes the sound does not turn it off: what was before it is noted first.
let wasWaiting = false;
for (const name of ['pointerdown', 'keydown']) addEventListener(name, () => { wasWaiting = window.rocsafe.sound?.state === 'waiting'; }, { capture: true });
const sound = window.rocsafe.sound = new Sound();
function nameSound() {
  $('#sound').dataset.state = sound.state;
  $('#sound').setAttribute('aria-pressed', String(sound.state === 'on'));
  $('#sound').textContent = t(`sound_${sound.state}`);
}
sound.addEventListener('state', nameSound);
nameSound();
$('#sound').addEventListener('click', () => { if (!wasWaiting) sound.toggle(); });

link.addEventListener('sections', ({ detail }) => {
  orders.draw();
  const { mission, session, alarms } = link.sections;
const { access } = link.sections;
  $('#mission').replaceChildren(...(session?.is_hidden ? [t('hidden')] : mission ? [make('b', { text: mission.id, title: mission.id }), make('span', { class: `badge badge-${mission.phase}`, text: t(`phase_${mission.phase}`) }), access?.commander ? make('span', { class: 'note', text: t('commanded_by', { name: access.commander }) }) : ''] : [t('no_mission')]));
  const who = $('#who');
  who.hidden = !session;
  if (session) who.textContent = t('who', { user: session.user, role: session.role });
  if (alarms && (detail.isHello || detail.names.includes('alarms'))) {
    sound.hear(alarms, detail.isHello);
  }
});

// What all must know: nothing is heard, or all is over.
function bannerText(isLive, isMissionOld, missionAge, ended) {
  const since = (seconds) => (isNumber(seconds) ? age(seconds) : '–');
  if (!isLive) return link.hasEnded ? t('banner_ended') : t('banner_lost', { age: since(link.silence) });
  if (isMissionOld) return t('banner_mission', { age: since(missionAge) });
  return ended ? t('banner_over', { phase: t(`phase_${ended.phase}`) }) : '';
}

// Whether it is live, told by the word and the colour, twice a second.
let wasOld = true;
let seen = {};
setInterval(() => {
  link.watch();
  const isLive = link.isLive;
  root.classList.toggle('not-live', !isLive);
  const { mission, mission_heard_s: heard } = link.sections;
  if (mission?.id !== seen.id) seen = { id: mission?.id, at: link.now };
  const missionAge = link.now - (heard ?? -Infinity);
  // Its first word may have been kept: whether more follow is known some seconds later.
  const isMissionOld = isLive && mission && !isOver(mission) && (isNumber(heard) ? missionAge : link.now - seen.at) > MISSION_SILENT_S;
  root.classList.toggle('mission-old', !isOver(mission) && !(missionAge <= MISSION_SILENT_S));
  // Who does not look hears that what he would see is old.
  const isOld = !isLive || Boolean(isMissionOld);
  if (isOld && !wasOld) sound.play('critical');
  wasOld = isOld;
  const pulse = $('#pulse');
  pulse.classList.toggle('old', isOld);
  const isEnd = isLive && isOver(mission);
  // A page without a mission is linked to its server, and shows nothing that lives.
  const isIdle = isLive && !mission && !link.sections.session?.is_hidden;
  pulse.classList.toggle('over', isEnd || isIdle);
  const word = t(isOld ? 'not_live' : isEnd ? 'over' : isIdle ? 'idle' : 'live');
  if (pulse.textContent !== word) pulse.textContent = word;
  const banner = $('#banner');
  const text = bannerText(isLive, isMissionOld, missionAge, isEnd ? mission : null);
  banner.hidden = !text;
  banner.classList.toggle('over', isEnd);
  // Told anew only where it differs: a reader of the screen would say it twice a second.
  if (banner.dataset.told !== `${text} ${mission?.id}`) {
    banner.dataset.told = `${text} ${mission?.id}`;
    banner.replaceChildren(text, ...(isEnd ? [' ', reportLink(mission), ' ', make('button', { type: 'button', class: 'link', text: t('over_runs'), onclick: () => show('runs') })] : []));
  }
  if (isNumber(link.now)) {
    const [local, utc] = clockText(link.now);
    const both = utc.startsWith(local) ? utc : `${t('local_time', { time: local })}\n${utc}`;
    const missionTime = link.sections.progress?.mission_time_s;
    $('#clock').textContent = [both, isNumber(missionTime) ? t('mission_clock', { time: missionClock(missionTime) }) : ''].filter(Boolean).join(' · ');
  }
  if (!isLive) map.schedule();
}, 500);

// Log-in.
const login = $('#login');
login.addEventListener('cancel', (event) => event.preventDefault());
function askLogin(needs, word = '') {
  const message = make('p', { class: 'warn', role: 'alert', text: word });
  if (needs === 'token') {
    login.replaceChildren(make('h2', { id: 'login-title', text: t('login_title') }), make('p', { text: t('login_token') }), message);
  } else {
    const name = make('input', { name: 'name', autocomplete: 'username', required: true, id: 'login-name' });
    const password = make('input', { name: 'password', type: 'password', autocomplete: 'current-password', required: true, id: 'login-password' });
    const submit = async (event) => {
      event.preventDefault();
      try { await ask('/api/login', { name: name.value, password: password.value }); begin(); } catch (error) { message.textContent = error.message; password.value = ''; }
    };
    login.replaceChildren(make('h2', { id: 'login-title', text: t('login_title') }), make('form', { onsubmit: submit }, make('label', { for: 'login-name', text: t('login_name') }), name, make('label', { for: 'login-password', text: t('login_password') }), password, make('button', { class: 'order', text: t('login_go') })), message);
  }
  if (!login.open) login.showModal();
}

// Who is logged in: everybody sees himself, a commander all, and ends their sessions.
const people = $('#people');
async function showPeople() {
  const mayEnd = (link.sections.session?.may ?? []).includes('revoke');
  const { sessions } = mayEnd ? await ask('/api/sessions').catch(() => ({ sessions: [] })) : { sessions: [] };
  const logOut = async () => { await ask('/api/logout', {}).catch(() => {}); location.reload(); };
  const row = (one) => {
    const end = async () => { await ask(`/api/sessions/${encodeURIComponent(one.public_id)}/revoke`, {}).catch((error) => orders.tell([], error.message)); showPeople(); };
    return make('li', { class: 'person' }, make('b', { text: t('who', one) }), make('span', { class: 'note', text: `${one.address} ${t('people_since', { time: clockText(one.began_s)[0] })}` }), one.is_own ? make('span', { text: t('people_you') }) : make('button', { type: 'button', class: 'small', text: t('people_end'), onclick: end }));
  };
  people.replaceChildren(make('h2', { id: 'people-title', text: t('people_title') }),
    sessions.length > 1 ? make('ul', {}, ...sessions.map(row)) : make('p', { text: mayEnd ? t('people_none') : t('who', link.sections.session) }),
    make('p', { class: 'run-buttons' }, make('button', { type: 'button', class: 'small', id: 'log-out', text: t('log_out'), onclick: logOut }), make('button', { type: 'button', class: 'small', text: t('close'), onclick: () => people.close() })));
  if (!people.open) people.showModal();
}
$('#who').addEventListener('click', showPeople);

// A place that is typed.
$('#find').addEventListener('submit', async (event) => {
  event.preventDefault();
  const input = $('#find-text');
  try {
    const { place: [lat, lng] } = await ask(`/api/coordinates?text=${encodeURIComponent(input.value)}`);
    map.map.setView([lat, lng], Math.max(map.map.getZoom(), 17), { animate: false });
    map.isFitted = true;
    input.setAttribute('aria-invalid', 'false');
    if (ruler.isOn) ruler.add({ lat, lng }); else if (!draft.isDrawing) showPlace({ lat, lng });
    $('#map').focus();
  } catch (error) { input.setAttribute('aria-invalid', 'true'); orders.tell([], error.message); }
});

function begin() {
  if (login.open) login.close();
  link.open();
}
link.addEventListener('closed', async ({ detail }) => {
  const answer = detail === REVOKED ? { user: null } : await ask('/api/hello').catch(() => null);
  if (answer && !answer.user) { link.close(); askLogin(answer.needs ?? (await ask('/api/hello')).needs, t('revoked')); }
});

async function start() {
  $('#layer-list').replaceChildren(...map.switches());
  $('#theme').addEventListener('click', turnTheme);
  const token = new URLSearchParams(location.hash.slice(1)).get('token');
  // The token leaves the address, so that it is in no history and on no screen.
  if (token) history.replaceState(null, '', location.pathname);
  const answer = (token && await ask('/api/token', { token }).catch(() => null)) || await ask('/api/hello');
  if (answer.user) begin(); else askLogin(answer.needs);
}

// Where letters are text or a choice they are no orders; who has just picked a vehicle may order it.
const WRITTEN_IN = 'input:not([type="checkbox"]), textarea, select';
document.addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches(WRITTEN_IN) || document.querySelector('dialog[open]')) return;
  const key = event.key;
  if (key === 't') turnTheme();
  else if (key === 'f') map.fit();
  else if (key === 'a') document.querySelector('#facts [data-alarm]')?.click();
  else if ('123'.includes(key)) show(['live', 'runs', 'draft'][Number(key) - 1]);
  else if (key === 'g') $('#find-text').focus();
  else if (key === 'Enter' && event.target.id === 'map') map.chooseMiddle();
  else if (key === 'm') { if (ruler.isOn) ruler.close(); else ruler.begin(); $('#map').focus(); }
  else if (key === 'Backspace' && ruler.isOn) ruler.undo();
  else if (key === 'Escape' && ruler.isOn) ruler.close();
  else if (key === 'c' && draft.isDrawing) draft.finish();
  else if (key === 'Backspace' && draft.isDrawing) draft.undo();
  else if (key === '?') showHelp();
  else if (!orders.onKey(key)) return;
  event.preventDefault();
});
function showHelp() {
  const help = $('#help');
  help.replaceChildren(make('h2', { id: 'help-title', text: t('help_title') }), make('ul', { class: 'keys' }, ...t('help').split('\n').map((line) => { const [key, does] = line.split('\t'); return make('li', {}, make('kbd', { text: key }), does); })), make('button', { type: 'button', class: 'small', text: t('close'), onclick: () => help.close() }));
  help.showModal();
}

start();
