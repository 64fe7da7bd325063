// SPDX-License-Identifier: Apache-2.0
// Orders in two steps: a button arms the order, a second press within some seconds sends it.
import { t, told } from './texts.js';
import { dose, duration, make } from './format.js';
import { ask } from './link.js';
import { wordOf } from './facts.js';

const VERBS = [['hold', 'h'], ['resume', 'r'], ['return', 'b'], ['land', 'l'], ['take', ''], ['release', ''], ['replan', 'p']];
// Of the whole mission, whatever is selected.
const OF_ALL = new Set(['replan']);
const TOUCH_S = 0.6;
// An answer that is lost is asked for again: the server sends an order once.
// The server gives up after seven.
const ANSWER_S = 10;
const ASK_AGAIN_S = [0.5, 1, 2, 4];
const SILENT = 'no answer';
const LOOK_MS = 500;
const OUTCOMES = { refused: 'outcome_refused', 'no answer': 'outcome_silent', 'state has changed': 'outcome_stale' };

export const newId = () => [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, '0')).join('');

export class Orders {
  constructor(element, link, selection) {
    this.element = element;
    this.link = link;
    this.selection = selection;
    this.armed = null;
    this.report = make('div', { class: 'results', role: 'status', 'aria-live': 'assertive', hidden: true });
    this.bar = make('div', { class: 'order-bar' });
    element.append(this.report, this.bar);
    this.draw();
  }

  names() {
    const chosen = [...this.selection].filter((name) => this.link.vehicles.has(name));
    return chosen.length ? chosen : [...this.link.vehicles.keys()];
  }

  what(names) {
    if (!names.length) return t('orders_none');
    return names.length === this.link.vehicles.size && names.length > 1 ? t('orders_all', { count: names.length }) : names.length > 3 ? `${names.length}` : names.join(', ');
  }

  may(verb) { return (this.link.sections.session?.may ?? []).includes(verb); }

  draw() {
    if (this.armed) return;
    const names = this.names();
    const key = `${document.documentElement.dataset.replay}|${names}|${(this.link.sections.session?.may ?? []).join()}`;
    if (this.drawn === key) return;
    this.drawn = key;
    const buttons = VERBS.filter(([verb]) => this.may(verb)).map(([verb, letter]) => make('button', {
      type: 'button', class: `order order-${verb}`, 'data-verb': verb, 'aria-keyshortcuts': letter || undefined, disabled: !names.length, text: t(`verb_${verb}`), onclick: () => this.arm(verb),
    }));
    this.bar.replaceChildren(make('span', { class: 'order-for', text: t(document.documentElement.dataset.replay ? 'orders_for_live' : 'orders_for', { what: this.what(names) }) }), ...buttons);
  }

  async arm(verb, names = OF_ALL.has(verb) ? [...this.link.vehicles.keys()] : this.names(), target = null) {
    if (!names.length || !this.may(verb) || this.armed) return;
    // The revisions are those that are on the screen now: the server refuses what has moved on.
    const revisions = Object.fromEntries(names.map((name) => [name, this.link.vehicles.get(name).facts.revision]));
    const id = newId();
    const armed = this.armed = { id, verb, names };
    if (verb === 'send') this.bar.replaceChildren(make('span', { class: 'order-for', text: t('planning_drive') }));
    try {
      const { until_s: until, drive } = await ask('/api/orders', { request_id: id, verb, revisions, ...(target ? { target } : {}) });
      if (this.armed === armed) this.offer(Object.assign(armed, { drive }), until);
    } catch (error) { this.disarm(); this.tell([], t('refused', { why: error.message })); }
  }

  offer(armed, until) {
    const words = { verb: t(`verb_${armed.verb}`), what: this.what(armed.names) };
    const confirm = make('button', { type: 'button', class: 'order order-confirm', text: t('confirm', words) });
    const left = make('span', { class: 'order-left' });
    const cancel = make('button', { type: 'button', class: 'order', text: t('cancel'), onclick: () => this.disarm() });
    let pressed = null;
    const send = () => { clearTimeout(pressed); this.send(armed); };
    // On glass a brush of a sleeve is no confirmation: the button is kept pressed.
    confirm.addEventListener('pointerdown', (event) => {
      if (event.pointerType !== 'touch') return;
      confirm.dataset.touch = '1';
      confirm.classList.add('pressing');
      pressed = setTimeout(send, TOUCH_S * 1000);
    });
    for (const name of ['pointerup', 'pointercancel', 'pointerleave']) confirm.addEventListener(name, () => { clearTimeout(pressed); confirm.classList.remove('pressing'); });
    // A double click, or a key that is kept down, is one decision and not two.
    confirm.addEventListener('keydown', (event) => { if (event.repeat) event.preventDefault(); });
    confirm.addEventListener('contextmenu', (event) => event.preventDefault());
    confirm.addEventListener('click', (event) => { if (event.detail > 1) return; if (confirm.dataset.touch) { delete confirm.dataset.touch; confirm.textContent = t('confirm_touch', words); } else send(); });
    this.bar.replaceChildren(confirm, cancel, left, ...(armed.drive ? [make('span', { class: 'order-offer', text: driveText(armed.drive) })] : []));
    this.onOffer?.(armed.drive ?? null);
    confirm.focus();
    const count = () => {
      if (this.armed !== armed || armed.isSent) return;
      const seconds = until - this.link.now;
      if (seconds <= 0) { this.disarm(); return; }
      left.textContent = t('confirm_left', { seconds: Math.ceil(seconds) });
      setTimeout(count, 200);
    };
    count();
  }

  async send(armed) {
    if (armed.isSent) return;
    armed.isSent = true;
    this.bar.replaceChildren(make('span', { class: 'order-for', text: t('sending') }));
    const verb = t(`verb_${armed.verb}`);
    try {
      const { results, unlogged } = await this.confirmed(armed.id);
      const done = results.filter((one) => one.outcome === 'done').length;
      this.tell(results, [t('sent', { verb, done, all: results.length }), unlogged ? t('unlogged', { why: told(unlogged) }) : ''].join(' '));
    } catch (error) { this.tell([], error.isUnknown ? t('sent_unknown', { verb }) : t('refused', { why: error.message })); }
    this.disarm();
  }

  // The results of an order, asked for until they are known. What was sent once may have been
  // obeyed: no later refusal takes that back.
  async confirmed(id) {
    let isUnknown = false;
    for (const wait of [...ASK_AGAIN_S, 0]) {
      try {
        const answer = await ask(`/api/orders/${id}/confirm`, {}, ANSWER_S);
        if (answer.results) return answer;
      } catch (error) {
        if (error.status) throw Object.assign(error, { isUnknown });
      }
      isUnknown = true;
      await new Promise((resolve) => { setTimeout(resolve, wait * 1000); });
    }
    throw Object.assign(new Error(), { isUnknown });
  }

  disarm() {
    const verb = this.armed?.verb;
    this.armed = null;
    this.drawn = null;
    this.onOffer?.(null);
    this.draw();
    if (verb) this.bar.querySelector(`[data-verb="${verb}"]`)?.focus();
  }

  tell(results, title) {
    // Who has not done it first, each in the order of the list of vehicles.
    const rank = ({ vehicle, outcome }) => (outcome === 'done') * 1e6 + (this.link.vehicles.get(vehicle)?.rank ?? 0);
    const rows = [...results].sort((a, b) => rank(a) - rank(b)).map((one) => make('li', { class: one.outcome === 'done' ? 'done' : 'bad' }, make('b', { text: `${one.outcome === 'done' ? '✓' : '✕'} ${one.vehicle} ` }), one.outcome === 'done' ? t('outcome_done') : `${t(OUTCOMES[one.outcome] ?? 'unknown')}: ${told(one.text)} `, one.outcome === SILENT ? make('b', { 'data-silent': one.vehicle }) : ''));
    this.report.replaceChildren(make('div', { class: 'results-head' }, make('b', { text: title }), make('button', { type: 'button', class: 'small', text: t('close'), onclick: () => { this.report.hidden = true; } })), make('ul', {}, ...rows));
    this.report.hidden = false;
    this.follow();
  }

  // Who has not answered in time may obey later: its state says so, as long as the list is shown.
  follow() {
    const silent = [...this.report.querySelectorAll('[data-silent]')];
    if (this.report.hidden || !silent.length) return;
    for (const one of silent) {
      const vehicle = this.link.vehicles.get(one.dataset.silent);
      const state = vehicle && !this.link.isStale(vehicle) ? t(`state_${wordOf(vehicle)}`) : t('stale');
      const text = t('state_now', { state });
      if (one.textContent !== text) one.textContent = text;
    }
    clearTimeout(this.following);
    this.following = setTimeout(() => this.follow(), LOOK_MS);
  }

  onKey(key) {
    if (key === 'Escape' && this.armed && !this.armed.isSent) { this.disarm(); return true; }
    if (key === 'Escape') this.report.hidden = true;
    const verb = VERBS.find(([, letter]) => letter === key)?.[0];
    if (verb) this.arm(verb);
    return Boolean(verb);
  }
}

function driveText(drive) {
  const words = { vehicle: drive.vehicle, time: duration(drive.duration_s), bound: duration(drive.lower_bound_s), dose: dose(drive.dose_usv), upper: dose(drive.dose_upper_usv) };
  const left = drive.left_out.length ? `; ${t('drive_left_out', { what: drive.left_out.join(', ') })}` : '';
  return `${t('drive_offer', words)}${left}`;
}
